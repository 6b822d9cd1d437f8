"""Physics of an arm's joints: their play (`backlash`), bearings off the axis, geometry and sensors."""
