"""The kinds of drag; every module here names one or several."""
