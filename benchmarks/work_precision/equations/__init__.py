"""The equations that the peers solve, in the forms that suit them, and the sea that moves them."""
