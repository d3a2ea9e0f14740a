"""Drivers of jde for robots that MuJoCo simulates."""
