//! Bags of ROS 2: databases, and the lists of their files.

use std::fs;
use std::path::Path;

use rusqlite::Connection;

use super::files::{lines, pipe, sparse, write};

/// The tables of a bag.
const TABLES: &str = "CREATE TABLE topics(id INTEGER PRIMARY KEY, name, type, serialization_format);
    CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id, timestamp, data);
    CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type, encoding, encoded_message_definition);";

/// A million topics.
pub(super) fn topics(folder: &Path) {
    let insert = "INSERT INTO topics SELECT number, '/t' || number, 'std_msgs/msg/Int32', 'cdr' FROM numbers";
    database(folder, &numbers(1_000_000, insert));
}

/// A million definitions.
pub(super) fn definitions(folder: &Path) {
    let insert = "INSERT INTO message_definitions SELECT number, 'a_msgs/msg/A' || number, 'ros2msg', 'int32 a' FROM numbers";
    database(folder, &numbers(1_000_000, insert));
}

/// A list of tables with half a million of them.
pub(super) fn tables(folder: &Path) {
    let insert = "INSERT INTO sqlite_schema SELECT 'table', 't' || number, 't' || number, 2, \
        'CREATE TABLE t' || number || '(a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p)' FROM numbers";
    database(
        folder,
        &format!("PRAGMA writable_schema = ON; {}", numbers(500_000, insert)),
    );
}

/// No tables.
pub(super) fn empty(folder: &Path) {
    database(
        folder,
        "DROP TABLE topics; DROP TABLE messages; DROP TABLE message_definitions",
    );
}

/// A message that states that it has 128 MB, and a text that does.
pub(super) fn stated_sizes(folder: &Path) {
    database(
        folder,
        "INSERT INTO topics VALUES(1, '/a', 'std_msgs/msg/Int32', 'cdr');
         INSERT INTO messages VALUES(1, 1, 5, zeroblob(3000000));
         INSERT INTO topics VALUES(2, zeroblob(3000000), 'std_msgs/msg/Int32', 'cdr');",
    );
    let path = folder.join("a.db3");
    let mut bytes = fs::read(&path).expect("it was written");
    // The type of a value of so many bytes is 12 more than twice as many, in groups of seven bits.
    let kind = [0x82, 0xee, 0x9b, 0x0c];
    let places: Vec<_> = (0..bytes.len() - 4)
        .filter(|at| bytes[*at..][..4] == kind)
        .collect();
    assert_eq!(places.len(), 2);
    for at in places {
        bytes[at..][..4].copy_from_slice(&[0xff, 0xff, 0xff, 0x7e]);
    }
    write(folder, "a.db3", bytes);
}

/// A file that only has the name of a database.
pub(super) fn garbage(folder: &Path) {
    write(folder, "a.db3", [0xa5; 100_000]);
}

/// The first bytes of a database, and nothing for a terabyte.
pub(super) fn only_head(folder: &Path) {
    write(folder, "a.db3", b"SQLite format 3\0");
    super::files::lengthen(folder, "a.db3");
}

/// A folder whose list names half a million files, each twice.
pub(super) fn listed(folder: &Path) {
    bag(folder, &lines(250_000, |n| format!("  - a{n}.db3\n  - a{n}.db3")));
}

/// A list of aliases that stand for ten times as many each.
pub(super) fn aliases(folder: &Path) {
    let level = |n: usize| format!("  - &a{} [{}]", n + 1, vec![format!("*a{n}"); 10].join(", "));
    bag(folder, &format!("  - &a0 [a.db3]\n{}", lines(20, level)));
}

/// A list that is in a hundred thousand others.
pub(super) fn deep(folder: &Path) {
    bag(folder, &format!("  - {}", "[".repeat(100_000)));
}

/// A bag whose database is a pipe, and whose list is a terabyte of nothing.
pub(super) fn special(folder: &Path) {
    sparse(folder, "metadata.yaml");
    pipe(folder, "a.db3");
}

/// Three thousand files of one bag.
pub(super) fn files(folder: &Path) {
    database(folder, "");
    let small = fs::read(folder.join("a.db3")).expect("it was written");
    (0..3000).for_each(|n| write(folder, &format!("a_{n}.db3"), &small));
    bag(folder, &lines(3000, |n| format!("  - a_{n}.db3")));
}

fn bag(folder: &Path, files: &str) {
    let text = format!("rosbag2_bagfile_information:\n  version: 5\n  relative_file_paths:\n{files}");
    write(folder, "metadata.yaml", text);
}

/// Writes a database with these statements.
fn database(folder: &Path, statements: &str) {
    let connection = Connection::open(folder.join("a.db3")).expect("a database");
    let settings = "PRAGMA synchronous = OFF; PRAGMA journal_mode = OFF;";
    let all = format!("{settings}{TABLES}BEGIN;{statements};COMMIT");
    connection.execute_batch(&all).expect("it is written");
    connection.close().expect("it is closed");
}

/// A statement that inserts rows from `numbers`, as many.
fn numbers(count: usize, insert: &str) -> String {
    let (into, select) = insert.split_once(" SELECT").expect("it selects");
    format!(
        "{into} WITH RECURSIVE numbers(number) AS (SELECT 10 UNION ALL SELECT number + 1 FROM numbers LIMIT {count}) \
         SELECT{select}"
    )
}
