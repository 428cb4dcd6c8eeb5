//! Creates an axle from the settings, at power-up.

use super::authority::Authority;
use super::brake::Brake;
use super::commutation::Commutation;
use super::encoder::Encoder;
use super::end_stops::EndStops;
use super::envelope::{Envelope, Envelopes};
use super::handshake::Handshake;
use super::homing::Homing;
use super::latch::Latch;
use super::offset::Offset;
use super::options::Options;
use super::set_points::NewestCommand;
use super::shaft::Shaft;
use super::sign_probe::SignProbe;
use super::stopping::Stopping;
use super::torque::TorqueMode;
use super::watches::{Bounds, Watches};
use super::windows::Windows;
use super::{ActiveLimit, Axle, SetPoint};
use crate::bus::cia402::State;
use crate::bus::scale::Scale;
use crate::constants::CONTROL_PERIOD;
use crate::faults::Faults;
use crate::math::Turns;
use crate::motor::angle_watch::AngleWatch;
use crate::motor::back_emf::BackEmf;
use crate::motor::limits::Limiter;
use crate::motor::profile::Motion;
use crate::settings::{Setting, Settings};

impl Axle {
    /// Creates an axle with these settings. Its bridge is off, and it is not homed unless it needs
    /// no homing.
    pub fn new(settings: &Settings) -> Self {
        let scale = Scale::Turning {
            bits: settings.get(Setting::PositionBits) as u32,
        };
        let reference = Turns::from_radians(settings.si(Setting::HomePosition));
        let travel = (
            Turns::from_radians(settings.si(Setting::PositionMinimum)),
            Turns::from_radians(settings.si(Setting::PositionMaximum)),
        );
        let travel = (travel.0 < travel.1).then_some(travel);
        Self::with_scale::<true>(settings, scale, reference, travel)
    }

    /// Creates an axle whose positions on the bus have another scale. The screw uses it. `WATCHES`
    /// is whether the role may have an [`AngleWatch`] and a sensor at its shaft.
    #[inline(never)] // each inlined copy takes stack
    pub(in crate::node) fn with_scale<const WATCHES: bool>(
        settings: &Settings,
        scale: Scale,
        home_position: Turns,
        travel: Option<(Turns, Turns)>,
    ) -> Self {
        let torque_per_ampere = torque_per_ampere(settings, scale);
        let sync_ticks = (settings.get(Setting::SyncPeriod) as u32 / 1_000).max(1);
        let (envelopes, envelope) = Envelopes::new(settings);
        let back_emf = BackEmf::new(settings);
        let shaft = if WATCHES {
            Shaft::new(settings, travel)
        } else {
            None
        };
        Self {
            scale,
            bounds: Bounds::new(settings),
            envelopes,
            envelope,
            torque_per_ampere,
            travel,
            sync_ticks,
            syncs_per_second: 1.0 / (sync_ticks as f32 * CONTROL_PERIOD),
            encoder: Encoder::new(settings),
            watches: Watches::default(),
            angle_watch: if WATCHES {
                AngleWatch::new(settings, &back_emf)
            } else {
                None
            },
            back_emf,
            limiter: Limiter::new(settings),
            snapshot: None,
            authority: Authority::new(settings),
            latch: Latch::default(),
            present: Faults::NONE,
            reported: Faults::NONE,
            state: State::SwitchOnDisabled,
            mode: 0,
            controlword: 0,
            newest: NewestCommand::new(),
            command: SetPoint {
                controlword: 0,
                mode: 0,
                target: 0,
            },
            motion: Motion::default(),
            offset: Offset::new(settings, 1.0 / torque_per_ampere),
            interpolation_ticks: 0,
            options: Options::new(settings, scale, torque_per_ampere, travel),
            handshake: Handshake::default(),
            torque: TorqueMode::default(),
            stopping: Stopping::new(),
            exit: None,
            brake: Brake::new(settings),
            commutation: Commutation::new(settings),
            sign_probe: SignProbe::new(settings),
            windows: Windows::default(),
            homing: Homing::new(settings, home_position),
            homed: settings.get(Setting::HomingDirection) == 0 && shaft.is_none(),
            shaft,
            end_stops: EndStops::default(),
            active_limit: ActiveLimit::None,
            lacks_slack: false,
            demand: 0.0,
        }
    }

    /// Takes over the gains and limits of these settings, which take effect at once. The current of
    /// an axle under power does not jump: the integral takes up the difference, within the current
    /// limit.
    pub fn retune(&mut self, settings: &Settings) {
        self.retune_as::<true>(settings);
    }

    /// As [`Axle::retune`], for the role that `WATCHES` says.
    #[inline(never)] // its stack is not that of the tick
    pub(in crate::node) fn retune_as<const WATCHES: bool>(&mut self, settings: &Settings) {
        let demanded = self.follow(self.envelope.full).current;
        let before = self.envelope.cascade.clone();
        self.envelopes.retune(settings, &mut self.envelope);
        self.offset.convert(&before, &self.envelope.cascade);
        if self.powered() {
            let demand = self.follow(self.envelope.full);
            let Envelope { cascade, full, .. } = &mut self.envelope;
            cascade.continue_at(before.amperes(demanded), &demand, *full);
        }
        self.bounds = Bounds::new(settings);
        self.limiter.retune(settings);
        self.encoder.retune(settings);
        self.options.retune(settings);
        self.back_emf.retune(settings);
        if WATCHES && let Some(watch) = &mut self.angle_watch {
            watch.retune(&self.back_emf);
        }
    }

    /// Takes over the torque constant of these settings, after a calibration has replaced the
    /// current loop.
    pub fn use_torque_constant(&mut self, settings: &Settings) {
        self.forget_rotor_angle();
        self.torque_per_ampere = torque_per_ampere(settings, self.scale);
        self.offset = Offset::new(settings, 1.0 / self.torque_per_ampere);
    }
}

/// Torque at the output shaft per current, in bus units per ampere.
fn torque_per_ampere(settings: &Settings, scale: Scale) -> f32 {
    let gear = settings.si(Setting::GearRatio);
    let torque_constant = settings.si(Setting::TorqueConstant) * gear;
    torque_constant * scale.torque_units()
}
