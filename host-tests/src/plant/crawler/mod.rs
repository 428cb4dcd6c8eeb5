//! The crawler of Kurc and Szybicki: one rigid body on two tracks that shear the ground under them.
//!
//! [`parameters`]: the constant model. [`ground`]: the ground's shape. `track`: belts, cells and ground. `body`: the rigid body.
//! Here: the order of one step. Slip is nowhere given: it comes out of the forces.

mod body;
pub mod ground;
pub mod parameters;
mod track;

pub use ground::Profile;
pub use parameters::{CrawlerParameters, Soil};

use crate::plant::Plant;
use crate::plant::b2p2::Payload;
use crate::plant::noise::Noise;
use crate::plant::receiver::Receiver;
use crate::plant::sensing::{BodyMotion, BodySensing};
use crate::plant::world::turn;
use crate::record::{BodyPose, BodyShape, Part, Sketch, Truth};
use body::{Body, MassProperties};
use ground::Ground;
use rapier3d_f64::math::Vector;
use tautrack::link::{BodySensors, Sensors, Shaft};
use track::{CELLS, Track};

/// Length of a step, s.
const DT: f64 = 1e-3;
/// Parts of a step in which body and ground are integrated: the ground is stiff.
const SUBSTEPS: usize = 4;
/// Substeps in which the robot comes to rest before a run, and the share of its speed that each leaves it.
const SETTLING: (usize, f64) = (8_000, 0.98);
/// Inclination from the ground from which the robot has turned over, rad: no centre of gravity is above an edge there any more.
const TURNED_OVER: f64 = 75.0 * core::f64::consts::PI / 180.0;

/// Speed of a belt below which it has no slip worth the name, m/s.
const SLOWEST: f64 = 0.01;
/// Names of what each track shows: rates of sprocket and motor, speed and share of its slip.
const CHANNELS: [[&str; 4]; 2] = [
    [
        "left_sprocket_radps",
        "left_motor_radps",
        "left_skid_mps",
        "left_slip_1",
    ],
    [
        "right_sprocket_radps",
        "right_motor_radps",
        "right_skid_mps",
        "right_slip_1",
    ],
];

/// The crawler on its ground.
pub struct Crawler {
    parameters: CrawlerParameters,
    ground: Ground,
    body: Body,
    tracks: [Track; 2],
    sensing: BodySensing,
    receiver: Receiver,
    step: u64,
    payload: Option<Payload>,
    truth: Truth,
}

impl Crawler {
    /// The robot at the origin of the ground; `seed` is that of the sensors' noise.
    pub fn new(parameters: &CrawlerParameters, profile: &Profile, seed: u64) -> Self {
        let p = *parameters;
        let ground = Ground::new(profile);
        let [heading, left] = p.initial_heading_and_y;
        let payload = p.payload.filter(|payload| payload.from_time_s <= 0.0);
        let properties = MassProperties::new(&p, payload);
        let start = ground.start();
        let mut body = Body::at_rest(
            properties,
            start * Vector::new(0.0, left, 0.0),
            start * turn(Vector::Z, heading),
        );
        let mut tracks = [0.5, -0.5].map(|side: f64| Track::new(side * p.track_spacing));
        let (substeps, left_over) = SETTLING;
        for _ in 0..substeps {
            integrate(&p, &ground, &mut body, &mut tracks);
            body.velocity *= left_over;
            body.spin *= left_over;
        }
        (body.velocity, body.spin) = (Vector::ZERO, Vector::ZERO);
        let mut plant = Self {
            ground,
            body,
            tracks,
            sensing: BodySensing::new(&p.body_sensors, Noise::new(seed), body.rotation),
            receiver: Receiver::new(p.receiver, Noise::new(seed)),
            step: 0,
            payload,
            truth: Truth::default(),
            parameters: p,
        };
        plant.observe();
        plant
    }

    /// Advances by one millisecond under the motion of the two sprockets, left and right; `None` is a dead node.
    pub fn advance(&mut self, sprockets: [Option<&Shaft>; 2]) {
        let p = &self.parameters;
        let due = p
            .payload
            .filter(|payload| self.step as f64 * DT >= payload.from_time_s);
        if self.payload.is_none() && due.is_some() {
            self.payload = due;
            self.body.load(MassProperties::new(p, due));
        }
        self.step += 1;
        for (track, shaft) in self.tracks.iter_mut().zip(sprockets) {
            track.drive(shaft, p, DT);
        }
        // Once it has turned over it lies there: nothing of what follows is worth knowing.
        if !self.truth.toppled {
            let mut traction = [0.0; 2];
            for _ in 0..SUBSTEPS {
                let part = integrate(p, &self.ground, &mut self.body, &mut self.tracks);
                traction = [0, 1].map(|side: usize| traction[side] + part[side] / SUBSTEPS as f64);
            }
            for (track, traction) in self.tracks.iter_mut().zip(traction) {
                track.pull(traction, DT);
            }
        }
        self.observe();
        if self.truth.toppled {
            (self.body.velocity, self.body.spin) = (Vector::ZERO, Vector::ZERO);
            self.tracks
                .iter_mut()
                .for_each(|track| track.traction = 0.0);
        }
        let sensors = &self.parameters.body_sensors;
        let place = self
            .body
            .place(Vector::from_array(sensors.accelerometer_place));
        let motion = BodyMotion {
            rotation: self.body.rotation,
            velocity: self.body.velocity_at(place),
        };
        self.sensing.update(sensors, &motion, self.step);
        let antenna = self
            .body
            .place(Vector::from_array(self.parameters.receiver.antenna));
        self.receiver.update(
            antenna.to_array(),
            self.body.velocity_at(antenna).to_array(),
            self.step,
        );
    }

    /// Speed of the middle between the runs along the robot's own forward axis, m/s: what a sensor under the belly would see.
    pub fn speed_over_ground(&self) -> f64 {
        let middle = self.body.place(Vector::ZERO);
        let forward = self.body.rotation * Vector::X;
        self.body.velocity_at(middle).dot(forward)
    }

    /// Slip of left and right track by speeds, `1 - v / (r alpha)`; 0 for a belt slower than 10 mm/s.
    pub fn slip(&self) -> [f64; 2] {
        let forward = self.body.rotation * Vector::X;
        [0, 1].map(|side: usize| {
            let track = &self.tracks[side];
            let middle = self
                .body
                .place(0.5 * (track.cell(0, 1.0) + track.cell(CELLS - 1, 1.0)));
            if track.speed.abs() < SLOWEST {
                0.0
            } else {
                1.0 - self.body.velocity_at(middle).dot(forward) / track.speed
            }
        })
    }

    /// Brings the truth up to date.
    fn observe(&mut self) {
        let (p, body) = (&self.parameters, &self.body);
        let [forward, left, up] =
            [Vector::X, Vector::Y, Vector::Z].map(|axis| body.rotation * axis);
        let heading = left.cross(Vector::Z).normalize_or_zero();
        let cog = body.cog;
        let middle = body.place(Vector::ZERO);
        let truth = &mut self.truth;
        truth.pitch = libm::atan2(forward.dot(heading.cross(left)), forward.dot(heading));
        truth.roll = libm::atan2(left.z, libm::sqrt(left.x * left.x + left.y * left.y));
        truth.yaw = libm::atan2(heading.y, heading.x);
        truth.pitch_rate = -body.spin.dot(left);
        let rear = Vector::new(-0.5 * p.contact_length, 0.0, p.sprocket_radius);
        truth.axle_1 = body.place(rear).to_array();
        truth.cog = cog.to_array();
        truth.ground_speed = body.velocity.dot(heading);
        truth.belt_speed = self.tracks.map(|track| track.speed);
        let lost = |side: usize| {
            let track = &self.tracks[side];
            let place = body.place(track.cell(CELLS / 2, p.contact_length));
            (track.speed - body.velocity_at(place).dot(forward)).abs()
        };
        truth.slip += 0.5 * (lost(0) + lost(1)) * DT;
        truth.contacts.clear();
        let (mut rearmost, mut foremost) = (f64::INFINITY, f64::NEG_INFINITY);
        for track in &self.tracks {
            for cell in (0..CELLS).filter(|cell| track.loaded[*cell]) {
                let place = body.place(track.cell(cell, p.contact_length));
                let along = (place - cog).dot(heading);
                rearmost = if along < rearmost { along } else { rearmost };
                foremost = if along > foremost { along } else { foremost };
                truth.contacts.push(place.to_array());
            }
        }
        let supported = !truth.contacts.is_empty();
        truth.backward_margin = supported.then_some(-rearmost);
        truth.forward_margin = supported.then_some(foremost);
        let (_, normal) = self.ground.height(middle);
        truth.toppled |= up.dot(normal) < libm::cos(TURNED_OVER);
        self.name_channels();
    }

    /// What the paper's Figs. 7 and 8 show, and the sketch's places.
    fn name_channels(&mut self) {
        let p = &self.parameters;
        let (slip, over_ground) = (self.slip(), self.speed_over_ground());
        let channels = &mut self.truth.channels;
        channels.insert("speed_over_ground_mps", over_ground);
        for (side, names) in CHANNELS.iter().enumerate() {
            let speed = self.tracks[side].speed;
            let rate = speed / p.sprocket_radius;
            let values = [rate, rate * p.gear_ratio, slip[side] * speed, slip[side]];
            for (name, value) in names.iter().zip(values) {
                channels.insert(name, value);
            }
        }
        let half = 0.5 * p.contact_length;
        let (r, [length, _, height]) = (p.sprocket_radius, p.extent);
        let load = self.payload.map_or(p.cog, |payload| payload.place);
        let places = [
            [-half, r],
            [half, r],
            [-half, 0.0],
            [half, 0.0],
            [half, 2.0 * r],
            [-half, 2.0 * r],
            [-0.5 * length, p.cog[2]],
            [0.5 * length, p.cog[2]],
            [0.5 * length, p.cog[2] + 0.5 * height],
            [-0.5 * length, p.cog[2] + 0.5 * height],
            [load[0], load[2]],
        ];
        self.truth.points = places
            .map(|[x, z]| self.body.place(Vector::new(x, 0.0, z)).to_array())
            .to_vec();
    }
}

/// Advances body and ground by one substep; hands back the tractions of the tracks, N.
fn integrate(
    parameters: &CrawlerParameters,
    ground: &Ground,
    body: &mut Body,
    tracks: &mut [Track; 2],
) -> [f64; 2] {
    let dt = DT / SUBSTEPS as f64;
    let [left, right] = tracks
        .each_mut()
        .map(|track| track.act(parameters, ground, body, dt));
    body.step(left.force + right.force, left.moment + right.moment, dt);
    [left.traction, right.traction]
}

impl Plant for Crawler {
    fn step(&mut self, shafts: &[Option<Shaft>]) {
        self.advance([0, 1].map(|motor: usize| shafts.get(motor).and_then(Option::as_ref)));
    }

    fn sensors(&self, motor: usize) -> Sensors {
        let radius = self.parameters.sprocket_radius;
        let torque = self
            .tracks
            .get(motor)
            .map(|track| track.shaft_torque(radius));
        Sensors {
            shaft_torque: torque.unwrap_or(0.0) as f32,
            bus_voltage: self.parameters.bus_voltage as f32,
            ..Sensors::default()
        }
    }

    fn body_sensors(&self) -> BodySensors {
        self.sensing.reading()
    }

    fn serial(&self) -> &[u8] {
        self.receiver.sent()
    }

    fn sketch(&self) -> Sketch {
        let r = self.parameters.sprocket_radius;
        Sketch {
            circles: vec![(0, r), (1, r)],
            lines: vec![
                vec![2, 3],
                vec![4, 5],
                vec![6, 7, 8, 9, 6],
                vec![10, 6],
                vec![10, 7],
            ],
        }
    }

    fn bodies(&self) -> Vec<BodyShape> {
        let p = &self.parameters;
        let track = |side: f64| Part::Box {
            centre: [0.0, side * p.track_spacing, p.sprocket_radius],
            size: [
                p.contact_length + 2.0 * p.sprocket_radius,
                p.track_width,
                2.0 * p.sprocket_radius,
            ],
        };
        let hull = Part::Box {
            centre: [0.0, 0.0, p.cog[2]],
            size: p.extent,
        };
        vec![BodyShape {
            name: "body",
            parts: vec![hull, track(0.5), track(-0.5)],
        }]
    }

    fn poses(&self) -> Vec<BodyPose> {
        vec![BodyPose {
            place: self.body.place(Vector::ZERO).to_array(),
            rotation: self.body.rotation.to_array(),
        }]
    }

    fn ground_height(&self, place: [f64; 2]) -> f64 {
        self.ground.surface(place)
    }

    fn truth(&self) -> &Truth {
        &self.truth
    }

    fn truth_bits(&self, sink: &mut dyn FnMut(&[u8])) {
        let mut put = |value: f64| sink(&value.to_bits().to_le_bytes());
        let body = &self.body;
        body.rotation.to_array().into_iter().for_each(&mut put);
        for vector in [body.cog, body.velocity, body.spin] {
            vector.to_array().into_iter().for_each(&mut put);
        }
        for track in &self.tracks {
            [track.speed, track.traction].into_iter().for_each(&mut put);
            track.shear.into_iter().flatten().for_each(&mut put);
        }
        self.sensing.bits(&mut put);
        self.receiver.wander().into_iter().for_each(&mut put);
        put(self.truth.slip);
    }
}
