"""vda5050_bench: a small master that tries any VDA 5050 vehicle, rule by rule of the standard.

Knows the wire only: nothing here uses the adapter's own codecs or values.
"""
