"""From command to reading: instrument, recordings, the measurement chain, all physics by where it acts, model files."""
