"""Where the problems truly end: closed forms, and integrations in two ways."""
