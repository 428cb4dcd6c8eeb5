//! Ground truth of the crawler, as recorded in a run.

use super::Crawler;
use super::step::DT;
use super::track::CELLS;
use rapier3d_f64::math::Vector;

/// Inclination against the ground above which the robot counts as toppled, rad. The centre of
/// gravity is then no longer above any edge of the support.
const TURNED_OVER: f64 = 75.0 * core::f64::consts::PI / 180.0;
/// Channel names of each track: rates of sprocket and motor, speed of its slip, and slip ratio.
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

impl Crawler {
    /// Updates the ground truth after a step.
    pub(super) fn observe(&mut self) {
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

    /// Writes the channels that the paper's Figs. 7 and 8 show, and the points of the sketch.
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
