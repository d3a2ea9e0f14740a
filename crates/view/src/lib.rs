//! Windows on running applications.
