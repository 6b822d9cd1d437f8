"""The platform and the mount of the payload."""
