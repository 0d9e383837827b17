"""What pushes the cart beside all that its model explains: observed, told, and kept from what learns parameters."""
