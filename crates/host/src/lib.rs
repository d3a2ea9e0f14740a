//! Applications, plugins, executors and supervision.
