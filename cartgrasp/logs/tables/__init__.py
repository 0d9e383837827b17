"""Tables of anybody's columns as run logs, through a map."""
