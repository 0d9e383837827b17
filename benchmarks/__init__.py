"""Speed beside other programs, in one interleaved run: `python -m benchmarks`. Nothing here is a test."""
