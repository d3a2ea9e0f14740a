//! The log: five macros, `trace!(cx, "...")` to `error!(cx, "...")`, with the arguments of `format!`.

/// Logs a message for the developer of this schema; may occur in every iteration.
#[macro_export]
macro_rules! trace {
    ($cx:expr, $($text:tt)+) => {
        $cx.log($crate::Severity::Trace, ::core::format_args!($($text)+))
    };
}

/// Logs a message for the developer of this schema.
#[macro_export]
macro_rules! debug {
    ($cx:expr, $($text:tt)+) => {
        $cx.log($crate::Severity::Debug, ::core::format_args!($($text)+))
    };
}

/// Logs a message for the operator of the application.
#[macro_export]
macro_rules! info {
    ($cx:expr, $($text:tt)+) => {
        $cx.log($crate::Severity::Info, ::core::format_args!($($text)+))
    };
}

/// Logs a problem after which the schema continues.
#[macro_export]
macro_rules! warn {
    ($cx:expr, $($text:tt)+) => {
        $cx.log($crate::Severity::Warn, ::core::format_args!($($text)+))
    };
}

/// Logs a failure.
#[macro_export]
macro_rules! error {
    ($cx:expr, $($text:tt)+) => {
        $cx.log($crate::Severity::Error, ::core::format_args!($($text)+))
    };
}
