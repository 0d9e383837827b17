"""Where the arms are to hold during a run: the ways to choose, all behind `cartgrasp.roles.ContactSource`."""
