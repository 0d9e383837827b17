"""The parts of the filtered-regressor estimator."""
