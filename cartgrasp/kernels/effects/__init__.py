"""What each effect does: a file for each, by the effect's name, which `vocabulary.py` finds."""
