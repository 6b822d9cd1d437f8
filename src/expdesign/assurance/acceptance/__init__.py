"""Whether a calibrated robot is accepted: expanded uncertainty against tolerance, before and after measuring."""
