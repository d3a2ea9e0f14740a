//! Tests of application files: what is accepted, and the faults of the others.

mod catalogue;
mod family;
mod file;
mod good;
mod groups;
mod keys;
mod link;
mod lists;
mod remote;
mod roots;
mod times;
mod values;
mod web;
mod wiring;
