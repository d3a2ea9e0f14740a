//! Streams on pipes that are read late, never, or no longer.

use std::io::{BufRead, BufReader, PipeReader, pipe};
use std::os::fd::OwnedFd;
use std::thread;

use super::*;

/// More lines than the pipe and the queue can hold.
const MANY: u64 = 4 * MAX_PIECES as u64;

fn stream() -> (Arc<Stream>, &'static BlockingPolicy, PipeReader) {
    let (reader, writer) = pipe().unwrap();
    let policy: &'static BlockingPolicy = Box::leak(Box::new(BlockingPolicy::new()));
    let file = File::from(OwnedFd::from(writer));
    (Stream::start("test", file, policy, true).unwrap(), policy, reader)
}

fn line(number: u64) -> String {
    format!("{number} {}\n", ".".repeat(80))
}

fn print(stream: &Arc<Stream>, lines: impl Iterator<Item = u64>) {
    let mut printer = Printer::new(Some(Arc::clone(stream)), true);
    lines.for_each(|number| printer.write_all(line(number).as_bytes()).unwrap());
}

#[test]
fn r7_printing_never_waits_while_a_robot_moves_and_gaps_are_reported_in_place() {
    let (stream, policy, reader) = stream();
    policy.never_block();
    // This returns although the pipe is not read.
    print(&stream, 0..MANY);
    let lost = stream.lost();
    assert!(lost > 0);
    policy.block();
    let late = Arc::clone(&stream);
    let printing = thread::spawn(move || print(&late, MANY..=MANY));
    let (mut next, mut reported, mut gap_began) = (0, 0, false);
    for line in BufReader::new(reader).lines() {
        let line = line.unwrap();
        let first = line.split(' ').next().unwrap();
        if let Ok(number) = first.parse::<u64>() {
            assert_eq!(number, next + reported, "the gap was reported before");
            (next, reported) = (number + 1, 0);
            if number == MANY {
                break;
            }
        } else if line.contains("further lines") {
            gap_began = true;
        } else {
            assert!(gap_began && line.contains("dropped here"), "{line}");
            reported = first.trim_start_matches('[').parse().unwrap();
        }
    }
    printing.join().unwrap();
    assert_eq!((next, stream.lost()), (MANY + 1, lost));
}

#[test]
fn printing_that_may_wait_loses_nothing() {
    let (stream, _, reader) = stream();
    let late = Arc::clone(&stream);
    let printing = thread::spawn(move || print(&late, 0..MANY));
    let lines = BufReader::new(reader).lines().take(MANY as usize);
    for (number, line) in lines.enumerate() {
        assert!(line.unwrap().starts_with(&format!("{number} ")));
    }
    printing.join().unwrap();
    stream.drain().unwrap();
    assert!(stream.is_idle() && stream.lost() == 0);
}

#[test]
fn a_process_that_ends_does_not_wait_for_a_reader_that_reads_nothing() {
    let (stream, policy, _reader) = stream();
    let waiting = Arc::clone(&stream);
    let printing = thread::spawn(move || {
        print(&waiting, 0..MANY);
        waiting.drain().unwrap();
    });
    policy.finish_soon();
    printing.join().unwrap();
    assert!(!stream.is_idle() && stream.lost() > 0);
    // While a robot moves, the request to end does not change the patience: the robot comes to rest first.
    policy.never_block();
    policy.finish_soon();
    assert_eq!(*policy.0.lock(), BlockingMode::Never);
}

#[test]
fn a_closed_reader_is_reported_to_the_caller() {
    let (stream, _, reader) = stream();
    drop(reader);
    let mut printer = Printer::new(Some(Arc::clone(&stream)), false);
    printer.write_all(b"a line\n").unwrap();
    let error = printer.drain().unwrap_err();
    assert_eq!(error.kind(), io::ErrorKind::BrokenPipe);
}

#[test]
fn colours_are_left_out_of_a_line_that_is_printed_in_parts() {
    let (stream, _, reader) = stream();
    let mut printer = Printer::new(Some(Arc::clone(&stream)), true);
    write!(printer, "\u{1b}[1mone\u{1b}[0m").unwrap();
    writeln!(printer, " and \u{1b}[31mtwo").unwrap();
    printer.write_all(b"and a rest").unwrap();
    drop(printer);
    let mut lines = BufReader::new(reader).lines();
    assert_eq!(lines.next().unwrap().unwrap(), "one and two");
    stream.drain().unwrap();
}
