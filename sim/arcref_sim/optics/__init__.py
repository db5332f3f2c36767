"""The optics of the synthetic encoder: disc, reading heads and interpolator, from which its error follows."""
