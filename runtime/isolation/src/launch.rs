//! The first message to a child: the type to load, its ports and its limits; and the files of the memory that
//! it may map.

use std::io::{self, IoSlice, IoSliceMut};
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::net::UnixStream;

use jde_abi::lists::ListedPort;
use jde_app::Isolation;
use rustix::net::{
    RecvAncillaryBuffer, RecvAncillaryMessage, RecvFlags, SendAncillaryBuffer, SendAncillaryMessage,
    SendFlags, recvmsg, sendmsg,
};
use serde::{Deserialize, Serialize};

use super::TypeLocation;

/// The first message to a child.
#[derive(Debug, Serialize, Deserialize)]
pub struct Launch {
    /// The functions to run.
    pub code: TypeLocation,
    /// The schema's name.
    pub name: String,
    /// The number that identifies the run of the application.
    pub application: u64,
    /// The schema's seed.
    pub seed: u64,
    /// Whether a second of the application is a second of wall-clock time.
    pub real_time: bool,
    /// Its ports, in order.
    pub ports: Vec<PortInfo>,
    /// The ports of its lists, which are the last of them.
    pub listed: Vec<ListedPort>,
    /// The limits on its resources.
    pub limits: Isolation,
    /// The instance's number in the [`AuthorityTable`](crate::authority::AuthorityTable), which follows the files of the
    /// ports, if there is one. The last of the files is the plugin's, unless it is linked in.
    pub authority: Option<usize>,
}

/// The description of a port for a child.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct PortInfo {
    /// Whether it is bound to a variable that it writes.
    pub writes: bool,
    /// Bytes of a value; 0 for an unbound port.
    pub bytes: usize,
    /// Offset and length of the values in the next of the files, if they are in shared memory.
    pub memory: Option<(usize, usize)>,
    /// What it takes for the host to accept a value that it writes.
    pub acceptance: Acceptance,
}

/// What it takes for the host to accept a value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Acceptance {
    /// The host alone knows: a guard judges the value, it has limits, or the port writes nothing.
    #[default]
    ByHost,
    /// Nothing: it is an export.
    Always,
    /// No NaN and no infinity: it is a child's modulation.
    IfFinite,
    /// The same, and authority: it is a command.
    IfAuthorized,
}

/// This byte accompanies a file.
const WITH_FILE: u8 = 1;
/// This byte ends the files.
const END_OF_FILES: u8 = 0;

/// Sends open files; the receiver gets a descriptor of each.
pub fn send_files(stream: &UnixStream, files: &[OwnedFd]) -> io::Result<()> {
    for file in files {
        let mut space = [std::mem::MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(1))];
        let mut control = SendAncillaryBuffer::new(&mut space);
        let files = [file.as_fd()];
        control.push(SendAncillaryMessage::ScmRights(&files));
        sendmsg(
            stream,
            &[IoSlice::new(&[WITH_FILE])],
            &mut control,
            SendFlags::NOSIGNAL,
        )?;
    }
    let mut control = SendAncillaryBuffer::default();
    sendmsg(
        stream,
        &[IoSlice::new(&[END_OF_FILES])],
        &mut control,
        SendFlags::NOSIGNAL,
    )?;
    Ok(())
}

/// Receives the files. Must be called before anything else is read from the stream.
pub fn receive_files(stream: &UnixStream) -> io::Result<Vec<OwnedFd>> {
    let mut files = Vec::new();
    loop {
        let mut space = [std::mem::MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(1))];
        let mut control = RecvAncillaryBuffer::new(&mut space);
        let mut byte = [END_OF_FILES];
        let flags = RecvFlags::CMSG_CLOEXEC;
        let received = recvmsg(stream, &mut [IoSliceMut::new(&mut byte)], &mut control, flags)?;
        if received.bytes == 0 {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        for message in control.drain() {
            if let RecvAncillaryMessage::ScmRights(sent) = message {
                files.extend(sent);
            }
        }
        if byte[0] == END_OF_FILES {
            return Ok(files);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::fs::File;
    use std::io::{Read, Seek, Write};

    use super::*;

    #[test]
    fn files_arrive_in_order_and_bytes_after_them_are_not_lost() {
        let (sender, mut receiver) = UnixStream::pair().expect("a pair");
        let files = [3_u8, 5, 8].map(|byte| {
            let mut file = tempfile::tempfile().expect("a file");
            file.write_all(&[byte]).expect("a written byte");
            file.rewind().expect("a rewound file");
            OwnedFd::from(file)
        });
        send_files(&sender, &files).expect("sent files");
        (&sender).write_all(b"after").expect("sent bytes");
        let received = receive_files(&receiver).expect("received files");
        let read = received.into_iter().map(|file| {
            let mut byte = [0];
            File::from(file).read_exact(&mut byte).expect("a byte");
            byte[0]
        });
        assert_eq!(read.collect::<Vec<_>>(), [3, 5, 8]);
        let mut after = [0; 5];
        receiver.read_exact(&mut after).expect("received bytes");
        assert_eq!(&after, b"after");
    }
}
