//! How a process knows that somebody started it who starts it again when it ends.

/// Names the process id of `railgrip up` to its children, so that none outlives it.
pub(crate) const SUPERVISOR_VARIABLE: &str = "RAILGRIP_SUPERVISOR_PID";

/// True if `railgrip up` or systemd started this process and starts it again when it ends.
pub(crate) fn is_supervised() -> bool {
    is_of_up() || std::env::var_os("NOTIFY_SOCKET").is_some()
}

/// True if `railgrip up` started this process.
pub(crate) fn is_of_up() -> bool {
    std::env::var_os(SUPERVISOR_VARIABLE).is_some()
}
