//! A world of robots and sensors, stepped by its caller.
