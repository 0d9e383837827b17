"""ROS bags as run logs, and run logs as MCAP; no ROS is needed."""
