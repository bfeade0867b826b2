"""VDA 5050 itself: values, what they look like on the wire, and the rules of the standard."""
