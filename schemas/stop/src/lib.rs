//! Brakes while something stands in a very close area ahead.
