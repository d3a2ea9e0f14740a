//! Chunks: what a network makes of them, and which of their commands is given when.

use jde_schema::bench::Bench;
use jde_schema::prelude::*;
use jde_schema::types::{Chunk, ChunkStep};

use super::{entries, file, moving};
use crate::{Chunks, Steps};

fn looking(name: &str) -> Bench<Chunks> {
    let mut bench = Bench::<Chunks>::with_lists(&entries());
    bench.set("file", Text::<1024>::new(&file(name)));
    bench.awake().expect("the policy is right");
    bench
}

/// The chunk that it makes at a time, s, of these speeds.
fn look(bench: &mut Bench<Chunks>, at: f64, ahead: f64) -> Option<Chunk> {
    bench.set_now(Duration::from_secs_f64(at));
    bench.import("odometry", &moving(ahead, 0.0));
    bench.iterate().expect("an iteration is no fault");
    bench.exported("chunk")
}

#[test]
fn a_network_looks_ahead_and_its_chunk_is_as_old_as_what_it_saw() {
    let mut bench = looking("faster.toml");
    let chunk = look(&mut bench, 1.0, 0.5).expect("a chunk");
    let ahead: Vec<f32> = chunk.commands.iter().map(|twist| twist.linear.x as f32).collect();
    assert_eq!(ahead, [0.5, 0.6, 0.7, 0.8]);
    assert_eq!(
        (chunk.spacing, chunk.certainty, chunk.blend, chunk.blended),
        (0.1, 1.0, 0.5, 0)
    );
    assert_eq!(bench.exported_at("chunk"), Some(Duration::from_secs(1)));
    // A turn in between repeats nothing.
    look(&mut bench, 1.05, 0.0);
    assert_eq!(bench.exported_at("chunk"), Some(Duration::from_secs(1)));
    assert_eq!(look(&mut bench, 1.2, 0.0).map(|chunk| chunk.blended), Some(1));
    assert_eq!(look(&mut bench, 1.4, 0.0).map(|chunk| chunk.blended), Some(2));
    // Without a value there is no chunk, and the next one is blended with none of before.
    bench.retract("odometry");
    bench.set_now(Duration::from_secs_f64(1.6));
    bench.iterate().expect("an iteration is no fault");
    assert_eq!(bench.exported::<Chunk>("chunk"), None);
    assert_eq!(look(&mut bench, 1.8, 0.0).map(|chunk| chunk.blended), Some(0));
}

/// A chunk of these speeds, 0.1 s after one another.
fn chunk(speeds: &[f64]) -> Chunk {
    let mut chunk = Chunk {
        spacing: 0.1,
        certainty: 0.75,
        blend: 1.0,
        ..Chunk::default()
    };
    for (room, ahead) in chunk.commands.resize(speeds.len()).iter_mut().zip(speeds) {
        *room = Twist::planar(*ahead, 0.0);
    }
    chunk
}

/// A schema with a chunk of the time 1 s.
fn driving(chunk: &Chunk) -> Bench<Steps> {
    let mut bench = Bench::<Steps>::new();
    bench.awake().expect("it awakes");
    bench.set_now(Duration::from_secs(1));
    bench.import("chunk", chunk);
    bench
}

/// What it commands ahead at a time, s; `None` if it is not ready.
fn due(bench: &mut Bench<Steps>, at: f64) -> Option<f64> {
    bench.set_now(Duration::from_secs_f64(at));
    let is_ready = bench.check().expect("a check is no fault").ready;
    bench.iterate().expect("an iteration is no fault");
    let command = bench.commanded::<Twist>("base").expect("it commands");
    assert!(
        is_ready || command == Twist::ZERO,
        "it stands when it is not ready"
    );
    is_ready.then_some(command.linear.x)
}

#[test]
fn each_command_is_given_when_it_comes_due_and_after_the_last_it_is_not_ready() {
    let mut bench = driving(&chunk(&[0.1, 0.2, 0.3]));
    for (at, expected) in [(1.0, 0.1), (1.09, 0.1), (1.1, 0.2), (1.15, 0.2), (1.29, 0.3)] {
        assert_eq!(due(&mut bench, at), Some(expected), "at {at} s");
    }
    let step = bench
        .exported::<ChunkStep>("step")
        .expect("it says which step it was");
    assert_eq!((step.chunk, step.step, step.steps, step.blended), (1, 3, 3, 0));
    assert!((step.age - 0.29).abs() < 1e-9 && step.command.linear.x == 0.3);
    assert_eq!(bench.check().expect("a check is no fault").urgency, 0.75);
    assert_eq!(due(&mut bench, 1.3), None);
    assert_eq!(bench.exported::<ChunkStep>("step"), None);
    let words = "it commands nothing: chunk 1 has run out: its 3 commands lasted 0.3 s";
    assert!(
        bench.log().iter().any(|(_, text)| text == words),
        "{:?}",
        bench.log()
    );
    assert!(
        bench
            .draw()
            .expect("it draws")
            .texts()
            .iter()
            .any(|text| text.contains("has run out"))
    );
}

#[test]
fn a_new_chunk_replaces_the_one_before_and_its_late_commands_are_left_out() {
    let mut bench = driving(&chunk(&[0.1, 0.2, 0.3]));
    assert_eq!(due(&mut bench, 1.0), Some(0.1));
    bench.set_now(Duration::from_secs_f64(1.05));
    bench.import("chunk", &chunk(&[0.5, 0.6, 0.7]));
    // The network took 0.12 s.
    assert_eq!(due(&mut bench, 1.17), Some(0.6));
    bench.retract("chunk");
    assert_eq!(due(&mut bench, 1.2), None);
}

#[test]
fn a_blend_is_the_weighted_mean_of_what_chunks_say_of_one_time() {
    let mut bench = driving(&chunk(&[0.1, 0.2, 0.4]));
    assert_eq!(due(&mut bench, 1.0), Some(0.1));
    let blended = |speeds: &[f64], blended| Chunk {
        blend: 0.5,
        blended,
        ..chunk(speeds)
    };
    bench.set_now(Duration::from_secs_f64(1.1));
    bench.import("chunk", &blended(&[0.5, 0.7, 0.9], 1));
    // The older has the weight 1, the newer 0.5.
    let at = |bench: &mut Bench<Steps>, at: f64| due(bench, at).expect("it is ready");
    assert!((at(&mut bench, 1.1) - (0.2 + 0.5 * 0.5) / 1.5).abs() < 1e-12);
    assert!((at(&mut bench, 1.2) - (0.4 + 0.5 * 0.7) / 1.5).abs() < 1e-12);
    assert_eq!(bench.exported::<ChunkStep>("step").expect("a step").blended, 1);
    assert_eq!(due(&mut bench, 1.3), Some(0.9), "the older one is over");
    // One that begins anew is blended with none.
    bench.import("chunk", &blended(&[0.2], 0));
    assert_eq!(due(&mut bench, 1.3), Some(0.2));
}

#[test]
fn chunks_of_before_a_gap_have_no_share_in_a_blend() {
    // The host shows no value at the first check after the authority ended.
    let mut bench = driving(&chunk(&[1.0; 10]));
    assert_eq!(due(&mut bench, 1.0), Some(1.0));
    bench.retract("chunk");
    assert_eq!(due(&mut bench, 1.1), None);
    let newer = Chunk {
        blend: 1.0,
        blended: 5,
        ..chunk(&[0.5; 10])
    };
    bench.import("chunk", &newer);
    assert_eq!(due(&mut bench, 1.1), Some(0.5));
}

#[test]
fn what_is_no_chunk_is_refused_as_a_whole_in_words() {
    let of = |change: &dyn Fn(&mut Chunk)| {
        let mut chunk = chunk(&[0.1, 0.2, 0.3]);
        change(&mut chunk);
        chunk
    };
    let cases: [(Chunk, f64, &str); 10] = [
        (
            of(&|chunk| chunk.commands[2].linear.x = f64::NAN),
            1.0,
            "its command 3 of 3 has NaN",
        ),
        (of(&|chunk| chunk.commands.clear()), 1.0, "it has no command"),
        (
            of(&|chunk| chunk.spacing = 0.0),
            1.0,
            "its commands are due 0 s after one another",
        ),
        (
            of(&|chunk| chunk.spacing = -0.1),
            1.0,
            "its commands are due -0.1 s after one another",
        ),
        (
            of(&|chunk| chunk.spacing = f64::NAN),
            1.0,
            "its commands are due NaN s after one another",
        ),
        (
            of(&|chunk| chunk.spacing = 4.0),
            1.0,
            "it lasts 12 s, and 10 s is the most",
        ),
        (
            of(&|chunk| chunk.certainty = 1.5),
            1.0,
            "its maker is sure by 1.5: expected 0 to 1",
        ),
        (
            of(&|chunk| (chunk.blended, chunk.blend) = (1, 0.0)),
            1.0,
            "the weights of its blend fall by 0",
        ),
        (of(&|_| ()), 1.5, "it came after its last command was over"),
        (of(&|_| ()), 0.9, "its first command is not due yet"),
    ];
    for (chunk, at, expected) in cases {
        let mut bench = driving(&chunk);
        assert_eq!(due(&mut bench, at), None, "{expected}");
        let words = format!("chunk 1 is refused: {expected}");
        assert!(
            bench.log().iter().any(|(_, text)| text.contains(&words)),
            "{:?}",
            bench.log()
        );
    }
    let mut bench = driving(&of(&|chunk| chunk.certainty = 0.0));
    assert_eq!(due(&mut bench, 1.0), None);
}
