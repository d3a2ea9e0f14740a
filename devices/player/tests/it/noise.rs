//! Runs the checks of the fuzzers on changed sessions of a server.

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::Index;

use crate::checks;
use crate::server::{ALL, Server};

/// A whole session of a server, as a script for [`checks::session`].
fn script() -> Vec<u8> {
    let mut server = Server::new(&ALL);
    let mut session = jde_player::Session::new(jde_player::Options::default(), core::time::Duration::ZERO);
    let mut script = vec![0];
    let mut send = |session: &mut jde_player::Session, bytes: &[u8]| {
        for piece in bytes.chunks(255) {
            script.extend([0, piece.len() as u8]);
            script.extend(piece);
        }
        session.receive(bytes, core::time::Duration::ZERO);
    };
    send(&mut session, &server.connected());
    while session.robot().is_none() {
        let reply = server.receive(&session.output());
        send(&mut session, &reply);
    }
    send(&mut session, &server.data());
    script
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]
    #[test]
    fn a_session_accepts_any_server_and_moves_the_robot_only_on_request(
        changes in vec((any::<Index>(), any::<u8>()), 0..6),
        end in any::<Index>(),
    ) {
        let mut script = script();
        for (index, byte) in changes {
            let index = index.index(script.len());
            script[index] = byte;
        }
        script.truncate(script.len() - end.index(script.len() / 2));
        checks::session(&script);
    }
}
