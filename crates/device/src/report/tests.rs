//! The export of a connection's state, on the bench.

use core::time::Duration;

use jde_schema::bench::Bench;

use super::*;

/// Exports the state that its modulations describe.
#[derive(Describe)]
#[schema(driver, period = "10ms")]
struct Teller {
    /// The state: the codes of `Connection`, and 4 for looking.
    #[modulation(default = 0)]
    standing: Modulation<u32>,
    /// Attempts.
    #[modulation(default = 0)]
    attempts: Modulation<u32>,
    /// Name or reason.
    #[modulation(default = "")]
    words: Modulation<Text<120>>,
    /// The exported state.
    #[export]
    connection: Export<Connection>,
    report: ConnectionReport,
}

impl Schema for Teller {
    fn iterate(&mut self, cx: &Context) -> Result {
        let words = self.words.get(cx);
        let words = words.as_str();
        let standing = match self.standing.get(cx) {
            0 => ConnectionState::Idle,
            1 => ConnectionState::Connecting,
            2 => ConnectionState::Connected(words),
            3 => ConnectionState::Lost(words),
            _ => ConnectionState::Probing(words),
        };
        let attempts = self.attempts.get(cx);
        self.report.update(cx, &mut self.connection, standing, attempts);
        Ok(())
    }

    fn sleep(&mut self, cx: &Context) {
        self.report.retract(cx, &mut self.connection);
    }
}

/// Exports these states one after another, a second apart.
fn tell(bench: &mut Bench<Teller>, seconds: u64, steps: &[(u32, u32, &str)]) {
    for (second, &(standing, attempts, words)) in (seconds..).zip(steps) {
        bench.set("standing", standing);
        bench.set("attempts", attempts);
        bench.set("words", Text::<120>::new(words));
        bench.set_now(Duration::from_secs(second));
        bench.iterate().expect("it tells");
    }
}

fn log(bench: &Bench<Teller>) -> Vec<&str> {
    bench.log().iter().map(|(_, words)| &**words).collect()
}

#[test]
fn a_change_alone_is_told_with_its_time() {
    let mut bench = Bench::new();
    tell(&mut bench, 1, &[(1, 1, ""), (1, 1, ""), (1, 1, "")]);
    assert_eq!(bench.exported_at("connection"), Some(Duration::from_secs(1)));
    tell(&mut bench, 4, &[(4, 1, "scanner")]);
    assert_eq!(bench.exported_at("connection"), Some(Duration::from_secs(4)));
    let connection: Connection = bench.exported("connection").expect("it is told");
    assert_eq!(connection.state, Connection::CONNECTING);
    assert_eq!(
        connection.note.as_str(),
        "the line is open; looking for the scanner"
    );
    tell(&mut bench, 5, &[(4, 2, "scanner")]);
    let connection: Connection = bench.exported("connection").expect("it is told");
    assert_eq!(connection.attempts, 2);
    assert_eq!(log(&bench), [""; 0]);
}

#[test]
fn the_same_trouble_is_said_once_until_the_device_was_heard() {
    let mut bench = Bench::new();
    let again = [
        (3, 1, "no plug"),
        (1, 2, ""),
        (3, 2, "no plug"),
        (3, 3, "no plug"),
    ];
    tell(&mut bench, 1, &again);
    assert_eq!(log(&bench), ["no plug"]);
    tell(
        &mut bench,
        5,
        &[(3, 4, "no power"), (2, 5, "LMS"), (3, 0, "no power")],
    );
    assert_eq!(log(&bench), ["no plug", "no power", "LMS", "no power"]);
}

#[test]
fn who_is_heard_is_said_once_until_he_was_lost() {
    let mut bench = Bench::new();
    tell(&mut bench, 1, &[(2, 1, "LMS"), (2, 0, "LMS")]);
    assert_eq!(log(&bench), ["LMS"]);
    let connection: Connection = bench.exported("connection").expect("it is told");
    assert_eq!(connection.attempts, 0, "the number that changed is told");
    tell(&mut bench, 3, &[(4, 0, "scanner"), (2, 0, "LMS")]);
    assert_eq!(log(&bench), ["LMS", "LMS"]);
}

#[test]
fn asleep_it_is_forgotten() {
    let mut bench = Bench::new();
    tell(&mut bench, 1, &[(3, 1, "no plug")]);
    bench.sleep().expect("it sleeps");
    assert_eq!(bench.exported::<Connection>("connection"), None);
    tell(&mut bench, 2, &[(3, 1, "no plug")]);
    assert!(bench.exported::<Connection>("connection").is_some());
    assert_eq!(log(&bench), ["no plug", "no plug"]);
}
