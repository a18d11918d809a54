"""Other programs at the same task: static compliance and lowest frequencies of a Biglide."""
