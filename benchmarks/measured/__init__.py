"""Logs that nobody of this project made: truth beside what the commands say, on each log and on variants of it.

`python -m benchmarks.measured`. The data are no part of the project: they stand in a folder beside it.
"""
