"""A diagnosis, and what it tells: a sentence, what to run next, a page, figures and the files of a report."""
