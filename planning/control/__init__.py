"""What a robot's loop calls once a tick: tracker, filter, planner, contacts and regrasps as one."""
