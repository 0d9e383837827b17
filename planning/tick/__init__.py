"""One tick of the planner: what is given, what holds, by which road it is solved, and what is answered."""
