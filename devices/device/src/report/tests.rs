//! The export of a connection's state, on the bench.

use core::time::Duration;

use jde_schema::bench::Bench;

use super::*;

/// Exports the state that its modulations describe.
#[derive(Describe)]
#[schema(driver, period = "10ms")]
struct Reporter {
    /// The state: the codes of `Connection`, and 4 for probing.
    #[modulation(default = 0)]
    state: Modulation<u32>,
    /// Attempts.
    #[modulation(default = 0)]
    attempts: Modulation<u32>,
    /// Name or reason.
    #[modulation(default = "")]
    note: Modulation<Text<120>>,
    /// The exported state.
    #[export]
    connection: Export<Connection>,
    report: ConnectionReport,
}

impl Schema for Reporter {
    fn iterate(&mut self, cx: &Context) -> Result {
        let note = self.note.get(cx);
        let note = note.as_str();
        let state = match self.state.get(cx) {
            0 => ConnectionState::Idle,
            1 => ConnectionState::Connecting,
            2 => ConnectionState::Connected(note),
            3 => ConnectionState::Lost(note),
            _ => ConnectionState::Probing(note),
        };
        let attempts = self.attempts.get(cx);
        self.report.update(cx, &mut self.connection, state, attempts);
        Ok(())
    }

    fn sleep(&mut self, cx: &Context) {
        self.report.retract(cx, &mut self.connection);
    }
}

/// Exports these states one after another, a second apart.
fn report(bench: &mut Bench<Reporter>, seconds: u64, steps: &[(u32, u32, &str)]) {
    for (second, &(state, attempts, note)) in (seconds..).zip(steps) {
        bench.set("state", state);
        bench.set("attempts", attempts);
        bench.set("note", Text::<120>::new(note));
        bench.set_now(Duration::from_secs(second));
        bench.iterate().expect("an iteration");
    }
}

fn log(bench: &Bench<Reporter>) -> Vec<&str> {
    bench.log().iter().map(|(_, message)| &**message).collect()
}

#[test]
fn only_changes_are_exported_with_their_time() {
    let mut bench = Bench::new();
    report(&mut bench, 1, &[(1, 1, ""), (1, 1, ""), (1, 1, "")]);
    assert_eq!(bench.exported_at("connection"), Some(Duration::from_secs(1)));
    report(&mut bench, 4, &[(4, 1, "scanner")]);
    assert_eq!(bench.exported_at("connection"), Some(Duration::from_secs(4)));
    let connection: Connection = bench.exported("connection").expect("an exported state");
    assert_eq!(connection.state, Connection::CONNECTING);
    assert_eq!(
        connection.note.as_str(),
        "the line is open; looking for the scanner"
    );
    report(&mut bench, 5, &[(4, 2, "scanner")]);
    let connection: Connection = bench.exported("connection").expect("an exported state");
    assert_eq!(connection.attempts, 2);
    assert_eq!(log(&bench), [""; 0]);
}

#[test]
fn a_repeated_failure_is_logged_once_until_the_device_connects() {
    let mut bench = Bench::new();
    let failures = [
        (3, 1, "no plug"),
        (1, 2, ""),
        (3, 2, "no plug"),
        (3, 3, "no plug"),
    ];
    report(&mut bench, 1, &failures);
    assert_eq!(log(&bench), ["no plug"]);
    report(
        &mut bench,
        5,
        &[(3, 4, "no power"), (2, 5, "LMS"), (3, 0, "no power")],
    );
    assert_eq!(log(&bench), ["no plug", "no power", "LMS", "no power"]);
}

#[test]
fn a_connected_device_is_logged_once_until_it_is_lost() {
    let mut bench = Bench::new();
    report(&mut bench, 1, &[(2, 1, "LMS"), (2, 0, "LMS")]);
    assert_eq!(log(&bench), ["LMS"]);
    let connection: Connection = bench.exported("connection").expect("an exported state");
    assert_eq!(connection.attempts, 0, "a changed number of attempts is exported");
    report(&mut bench, 3, &[(4, 0, "scanner"), (2, 0, "LMS")]);
    assert_eq!(log(&bench), ["LMS", "LMS"]);
}

#[test]
fn a_device_that_does_not_reply_is_logged_once() {
    let mut bench = Bench::new();
    report(&mut bench, 1, &[(4, 1, "scanner"); 5]);
    assert_eq!(log(&bench), [""; 0]);
    report(&mut bench, 6, &[(4, 1, "scanner"); 9]);
    assert_eq!(log(&bench), ["the line is open; looking for the scanner"]);
    report(&mut bench, 15, &[(2, 1, "LMS"), (4, 1, "scanner"), (1, 1, "")]);
    report(&mut bench, 18, &[(4, 1, "scanner"); 5]);
    assert_eq!(log(&bench)[1..], ["LMS"]);
}

#[test]
fn sleeping_resets_the_report() {
    let mut bench = Bench::new();
    report(&mut bench, 1, &[(3, 1, "no plug")]);
    bench.sleep().expect("sleep");
    assert_eq!(bench.exported::<Connection>("connection"), None);
    report(&mut bench, 2, &[(3, 1, "no plug")]);
    assert!(bench.exported::<Connection>("connection").is_some());
    assert_eq!(log(&bench), ["no plug", "no plug"]);
}
