"""Steps of Kalman filters as scalar code, compiled by numba. Nothing here is imported before an estimator is made."""
