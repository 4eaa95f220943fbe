"""The equations that the peers solve, in the form that suits each, and the sea that moves them."""
