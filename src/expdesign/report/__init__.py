"""Report pages: results as one HTML file each, with one look and one choice of words for all of them."""
