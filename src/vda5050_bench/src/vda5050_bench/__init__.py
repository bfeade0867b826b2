"""vda5050_bench: a small master that tests any VDA 5050 vehicle, rule by rule of the standard.

It works on the JSON messages only; it does not use the codecs or values of `vda5050_protocol`.
"""
