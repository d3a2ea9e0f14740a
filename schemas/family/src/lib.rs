//! The second toy of the paper: padre and its children hijo1 and hijo2.
