//! A server for tests, with an encoder of its own, written from Player's interface definitions: it uses no
//! code of the library. It does no I/O. The robot has sonars at `ranger:0` and a laser at `ranger:1`, as in
//! Stage, and one of each other device.

/// An interface and an index.
pub(crate) type Address = (u16, u16);

pub(crate) const BASE: Address = (4, 0);
pub(crate) const SONARS: Address = (62, 0);
pub(crate) const LASER: Address = (62, 1);
pub(crate) const OLD_SONARS: Address = (5, 0);
pub(crate) const OLD_LASER: Address = (6, 0);
pub(crate) const BUMPERS: Address = (14, 0);
pub(crate) const POWER: Address = (2, 0);
pub(crate) const HEAD: Address = (8, 0);
pub(crate) const ALL: [Address; 8] = [HEAD, SONARS, BASE, LASER, OLD_LASER, POWER, BUMPERS, OLD_SONARS];

const DATA: u32 = 1;
const REQUEST: u32 = 3;
const ACCEPTED: u32 = 4;
const REFUSED: u32 = 6;

pub(crate) struct Server {
    pub(crate) version: &'static str,
    pub(crate) devices: Vec<Address>,
    /// Requests that it refuses, by address and subtype; a subscription by the address of its device and 0.
    pub(crate) refused: Vec<(Address, u32)>,
    pub(crate) pose: [f64; 3],
    pub(crate) stalled: bool,
    pub(crate) ranges: Vec<f64>,
    /// Whether it sends no data.
    pub(crate) silent: bool,
    /// Bytes to send before the next data.
    pub(crate) noise: Vec<u8>,
    /// Velocities that it received since the connection began.
    pub(crate) velocities: Vec<[f64; 3]>,
    /// Commands of the head: pan, tilt, field of view, speeds.
    pub(crate) heads: Vec<[f32; 5]>,
    pub(crate) motors_on: bool,
    pub(crate) subscribed: Vec<Address>,
    /// How often it was asked for data.
    pub(crate) polls: u32,
    received: Vec<u8>,
}

impl Server {
    pub(crate) fn new(devices: &[Address]) -> Self {
        Self {
            version: "3.1.0",
            devices: devices.to_vec(),
            refused: Vec::new(),
            pose: [1.0, 2.0, 0.5],
            stalled: false,
            ranges: vec![1.0, 2.0, 8.0, 0.01, 3.0],
            silent: false,
            noise: Vec::new(),
            velocities: Vec::new(),
            heads: Vec::new(),
            motors_on: false,
            subscribed: Vec::new(),
            polls: 0,
            received: Vec::new(),
        }
    }

    /// A client has connected. Returns the greeting.
    pub(crate) fn connected(&mut self) -> Vec<u8> {
        self.subscribed.clear();
        self.received.clear();
        self.velocities.clear();
        self.motors_on = false;
        let mut greeting = format!("Player v.{}", self.version).into_bytes();
        greeting.resize(32, 0);
        greeting
    }

    /// Returns the replies to bytes of a client.
    pub(crate) fn receive(&mut self, bytes: &[u8]) -> Vec<u8> {
        self.received.extend(bytes);
        let mut replies = Vec::new();
        while self.received.len() >= 40 {
            let size = word(&self.received, 9) as usize;
            if self.received.len() < 40 + size {
                break;
            }
            let message: Vec<u8> = self.received.drain(..40 + size).collect();
            let address = (word(&message, 2) as u16, word(&message, 3) as u16);
            replies.extend(self.answer(address, word(&message, 4), word(&message, 5), &message[40..]));
        }
        replies
    }

    fn answer(&mut self, address: Address, kind: u32, subtype: u32, body: &[u8]) -> Vec<u8> {
        let number = |index: usize| f64::from_be_bytes(body[8 * index..8 * index + 8].try_into().unwrap());
        match (address.0, kind, subtype) {
            (4, 2, 1) => {
                assert_eq!(
                    (body.len(), word(body, 6)),
                    (28, 1),
                    "three numbers and the motors' state"
                );
                self.velocities.push([number(0), number(1), number(2)]);
                return Vec::new();
            }
            (8, 2, 1) => {
                let angle = |index: usize| f32::from_bits(word(body, index));
                self.heads.push([0, 1, 2, 3, 4].map(angle));
                return Vec::new();
            }
            (_, REQUEST, _) => {}
            other => panic!("a client sends {other:?}"),
        }
        let is_subscription = (address.0, subtype) == (1, 3);
        let device = if is_subscription {
            (word(body, 2) as u16, word(body, 3) as u16)
        } else {
            address
        };
        let is_refused = (self.refused).contains(&(device, if is_subscription { 0 } else { subtype }));
        let kind = if is_refused { REFUSED } else { ACCEPTED };
        let fields = match (address.0, subtype) {
            (1, 1) => (self.devices.iter()).fold(Fields::count(self.devices.len()), |fields, device| {
                fields.words(&[0x0100_007f, 6665, device.0.into(), device.1.into()])
            }),
            (1, 3) => {
                let mode = if is_refused { 3 } else { word(body, 4) };
                self.subscribed.retain(|known| *known != device);
                if mode == 1 {
                    self.subscribed.push(device);
                }
                let fields = Fields::default().words(&[0, 0, device.0.into(), device.1.into(), mode]);
                return message(address, kind, subtype, &fields.bytes(b"stage\0").0);
            }
            (4, 2) => {
                self.motors_on = word(body, 0) == 1;
                Fields::default()
            }
            (62, 1) => {
                let elements = if address == SONARS { 4 } else { 1 };
                let poses = (0..elements).fold(Fields::count(elements), |fields, element| {
                    fields.pose(0.0, 0.1 * element as f64, 0.0)
                });
                let sizes = Fields::count(elements).doubles(&vec![0.0; 3 * elements]);
                let mount = Fields::default().pose(0.1 * f64::from(address.1), 0.0, 0.0);
                mount.doubles(&[0.2, 0.2, 0.1]).then(&poses).then(&sizes)
            }
            (62, 5) => Fields::default().doubles(&[-1.0, 1.0, 0.5, 0.05, 8.0, 0.0, 10.0]),
            (5, 1) => Fields::count(2).pose(0.2, 0.1, 0.5).pose(0.2, -0.1, -0.5),
            (6, 1) => Fields::default().pose(0.15, 0.0, 0.0).doubles(&[0.0; 3]),
            (14, 1) => {
                let places = [(0.2, -0.1), (0.2, 0.1), (-0.2, 0.0)];
                places.iter().fold(Fields::count(3), |fields, (x, y)| {
                    fields.pose(*x, *y, 0.0).floats(&[0.1, 0.0])
                })
            }
            other => panic!("a client requests {other:?}"),
        };
        message(address, kind, subtype, if is_refused { &[] } else { &fields.0 })
    }

    /// Returns the data of all subscribed devices.
    pub(crate) fn data(&mut self) -> Vec<u8> {
        self.polls += 1;
        let mut bytes = std::mem::take(&mut self.noise);
        for device in self.subscribed.iter().filter(|_| !self.silent) {
            let fields = Fields::default();
            let fields = match *device {
                BASE => fields
                    .doubles(&self.pose)
                    .doubles(&[0.3, 0.0, -0.1])
                    .words(&[self.stalled.into()]),
                SONARS => Fields::count(4).doubles(&[1.0, 2.0, 8.0, f64::NAN]),
                LASER => Fields::count(self.ranges.len()).doubles(&self.ranges),
                OLD_LASER => {
                    let ranges = Fields::count(5).floats(&[1.0, 2.0, 3.0, 4.0, 6.0]);
                    fields
                        .floats(&[-0.5, 0.5, 0.25, 6.0])
                        .then(&ranges)
                        .bytes(&[9; 5])
                        .words(&[77])
                }
                OLD_SONARS => Fields::count(2).floats(&[0.5, 5.0]),
                BUMPERS => fields.bytes(&[1, 0, 1]),
                POWER => fields
                    .words(&[1 | 8 | 16])
                    .floats(&[12.5, 80.0, 0.0, 0.0])
                    .words(&[-1_i32 as u32]),
                HEAD => fields.floats(&[0.1, 0.2, 0.8, 0.0, 0.0]).words(&[0]),
                other => panic!("{other:?} has no data"),
            };
            bytes.extend(message(*device, DATA, 1, &fields.0));
        }
        bytes
    }
}

/// The fields of a body in XDR.
#[derive(Default)]
struct Fields(Vec<u8>);

impl Fields {
    /// The count of an array, once as a field and once as part of the array.
    fn count(count: usize) -> Self {
        Self::default().words(&[count as u32; 2])
    }

    fn words(mut self, words: &[u32]) -> Self {
        self.0.extend(words.iter().flat_map(|word| word.to_be_bytes()));
        self
    }

    fn doubles(mut self, numbers: &[f64]) -> Self {
        self.0
            .extend(numbers.iter().flat_map(|number| number.to_be_bytes()));
        self
    }

    fn floats(mut self, numbers: &[f32]) -> Self {
        self.0
            .extend(numbers.iter().flat_map(|number| number.to_be_bytes()));
        self
    }

    fn then(mut self, others: &Self) -> Self {
        self.0.extend(&others.0);
        self
    }

    /// An array of bytes, padded to words.
    fn bytes(self, bytes: &[u8]) -> Self {
        let mut fields = self.then(&Self::count(bytes.len()));
        fields.0.extend(bytes);
        fields.0.resize(fields.0.len().next_multiple_of(4), 0);
        fields
    }

    fn pose(self, x: f64, y: f64, yaw: f64) -> Self {
        self.doubles(&[x, y, 0.3, 0.0, 0.0, yaw])
    }
}

pub(crate) fn message((interface, index): Address, kind: u32, subtype: u32, body: &[u8]) -> Vec<u8> {
    let address = [0x0100_007f, 6665, interface.into(), index.into(), kind, subtype];
    let header = Fields::default()
        .words(&address)
        .doubles(&[12.5])
        .words(&[0, body.len() as u32]);
    [&header.0, body].concat()
}

/// The word at an index of a message, whose header has a double as words 6 and 7.
fn word(bytes: &[u8], index: usize) -> u32 {
    u32::from_be_bytes(bytes[4 * index..4 * index + 4].try_into().unwrap())
}
