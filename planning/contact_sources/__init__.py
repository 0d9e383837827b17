"""Where the arms are to hold during a run: one file a way to choose, all behind `cartgrasp.roles.ContactSource`."""
