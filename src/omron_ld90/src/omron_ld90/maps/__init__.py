"""`.map` files of the LD-90."""
