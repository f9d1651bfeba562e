"""Speed, as ratios to TCT and libFAUDES and to the machine's own limits, measured in one run: ``make bench``."""
