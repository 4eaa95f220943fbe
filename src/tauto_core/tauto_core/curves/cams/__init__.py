"""The kinds of cam; every module here names one or several."""
