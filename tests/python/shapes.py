"""Footprints."""

import numpy as np

HOUSE = np.array([(40.0, 40.0), (60.0, 40.0), (60.0, 60.0), (40.0, 60.0)])
