"""The search for what a model lacks: candidates, their score, and which are added."""
