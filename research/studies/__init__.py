"""Studies: what the thesis shows, each as one file here and one configuration, with results that are kept."""
