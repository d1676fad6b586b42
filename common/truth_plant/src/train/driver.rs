//! The driver: a day of stops. Powers up to the limit, coasts, brakes for limits and stations as the brake allows,
//! holds at the platform, waits, and goes on.

use crate::random::Stream;

use super::line::Line;

/// Time between two looks at the line, s.
pub(crate) const LOOK_S: f64 = 0.1;

/// How this driver drives this train.
#[derive(Debug, Clone, Copy)]
pub struct DriverStyle {
    /// Retardation that braking is planned with, m/s².
    pub planned_m_s2: f64,
    /// Retardation of a full brake, as the driver knows the train, m/s².
    pub full_m_s2: f64,
    /// From the handle to the force, s.
    pub lag_s: f64,
    /// Shortest time between two movements of the brake handle, s.
    pub patience_s: f64,
    /// Notch of the brake handle; 0 for a continuous one.
    pub notch: f64,
    /// Falls so far below the limit while coasting before powering again, m/s.
    pub coast_m_s: f64,
    /// Stops last from, to, s.
    pub dwell_s: (f64, f64),
    /// Brake held at the platform.
    pub hold: f64,
    /// Time that a release of the train brake needs, s; the direct brake of the locomotive holds meanwhile.
    pub release_s: f64,
}

/// What the driver sees.
#[derive(Debug, Clone, Copy)]
pub(crate) struct View {
    pub(crate) time_s: f64,
    pub(crate) head_m: f64,
    pub(crate) v_m_s: f64,
    pub(crate) acceleration_m_s2: f64,
}

/// Where the handles are, all 0 to 1.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Handles {
    pub(crate) traction: f64,
    pub(crate) brake: f64,
    /// Direct brake of the locomotive.
    pub(crate) direct: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Mode {
    Standing {
        until_s: f64,
    },
    Powering,
    Coasting,
    Braking {
        target_m: f64,
        target_m_s: f64,
        full: bool,
    },
    /// Holds the speed on a descent.
    Retaining,
}

/// A driver at work.
#[derive(Debug, Clone)]
pub(crate) struct Driver {
    style: DriverStyle,
    mode: Mode,
    handles: Handles,
    station: usize,
    /// Factor on the planned retardation of this stop.
    mood: f64,
    trim: f64,
    moved_s: f64,
    felt_m_s2: f64,
    stream: Stream,
}

impl Driver {
    pub(crate) fn new(style: DriverStyle, mut stream: Stream) -> Self {
        let until_s = stream.uniform(15.0, 40.0) + style.release_s;
        let handles = Handles { brake: style.hold, ..Handles::default() };
        Self {
            style,
            mode: Mode::Standing { until_s },
            handles,
            station: 1,
            mood: 1.0,
            trim: 0.0,
            moved_s: 0.0,
            felt_m_s2: 0.0,
            stream,
        }
    }

    /// One look at the line; every [`LOOK_S`].
    pub(crate) fn look(&mut self, view: &View, line: &Line) -> Handles {
        self.felt_m_s2 += 0.12 * (view.acceleration_m_s2 - self.felt_m_s2);
        match self.mode {
            Mode::Standing { until_s } => self.stand(view, until_s),
            Mode::Braking { target_m, target_m_s, full } => {
                self.brake(view, line, target_m, target_m_s, full);
            }
            Mode::Retaining => self.retain(view, line),
            Mode::Powering | Mode::Coasting => self.run(view, line),
        }
        self.handles
    }

    fn stand(&mut self, view: &View, until_s: f64) {
        let releasing = view.time_s > until_s - self.style.release_s;
        self.handles = if self.style.release_s > 0.0 && releasing {
            Handles { direct: 0.8, ..Handles::default() }
        } else {
            Handles { brake: self.style.hold, ..Handles::default() }
        };
        if view.time_s >= until_s {
            self.mode = Mode::Powering;
            self.handles = Handles { traction: 0.3, ..Handles::default() };
            self.mood = self.stream.uniform(0.75, 1.2);
        }
    }

    /// Retardation that the nearest demanding target needs, and that target.
    fn needed(&self, view: &View, line: &Line) -> (f64, f64, f64) {
        let far_m = view.v_m_s * view.v_m_s / (0.8 * self.style.planned_m_s2) + 400.0;
        let next = line.limits.partition_point(|(from_m, _)| *from_m <= view.head_m);
        let limits = line.limits[next..].iter().take_while(|(from_m, _)| *from_m < view.head_m + far_m);
        let station_m = line.stations_m.get(self.station).copied().unwrap_or(f64::INFINITY);
        let need = |(at_m, speed): (f64, f64)| {
            let way_m = (at_m - view.head_m - view.v_m_s * self.style.lag_s).max(1.0);
            ((view.v_m_s * view.v_m_s - speed * speed) / (2.0 * way_m), at_m, speed)
        };
        let targets = limits.copied().chain([(station_m, 0.0)]).map(need);
        targets.fold((0.0, station_m, 0.0), |worst, next| if next.0 > worst.0 { next } else { worst })
    }

    fn run(&mut self, view: &View, line: &Line) {
        let (need, target_m, target_m_s) = self.needed(view, line);
        let planned = self.style.planned_m_s2 * self.mood;
        let limit = line.limit_m_s(view.head_m);
        if need > planned {
            let full = self.stream.chance(0.06);
            self.begin_braking(view, Mode::Braking { target_m, target_m_s, full });
            return;
        }
        if view.v_m_s > limit + 1.2 {
            self.begin_braking(view, Mode::Retaining);
            return;
        }
        let near = need > 0.55 * planned;
        self.mode = match self.mode {
            Mode::Powering if view.v_m_s > limit - 0.4 || near => Mode::Coasting,
            Mode::Coasting if view.v_m_s < limit - self.style.coast_m_s && !near => Mode::Powering,
            mode => mode,
        };
        // A long descent into the station must not end in the middle of nowhere.
        let crawling = view.v_m_s < 3.0 && target_m - view.head_m > 30.0;
        let wanted = if self.mode == Mode::Powering || crawling {
            ((limit - view.v_m_s) * 0.5).clamp(0.15, 1.0)
        } else {
            0.0
        };
        let wanted = if crawling && near { wanted.min(0.2) } else { wanted };
        let rise = 0.25 * LOOK_S;
        self.handles = Handles {
            traction: wanted.min(self.handles.traction + rise).max(self.handles.traction - 4.0 * rise),
            ..Handles::default()
        };
    }

    fn begin_braking(&mut self, view: &View, mode: Mode) {
        self.mode = mode;
        self.trim = 0.0;
        self.handles = Handles { brake: 0.12, ..Handles::default() };
        self.moved_s = view.time_s - self.style.patience_s + 0.4;
    }

    fn brake(&mut self, view: &View, line: &Line, target_m: f64, target_m_s: f64, full: bool) {
        if view.v_m_s < 0.02 {
            let dwell_s = self.stream.uniform(self.style.dwell_s.0, self.style.dwell_s.1);
            self.mode = Mode::Standing { until_s: view.time_s + dwell_s + self.style.release_s };
            if line.stations_m.get(self.station).is_some_and(|station| *station < view.head_m + 100.0) {
                self.station += 1;
            }
            return;
        }
        let way_m = target_m - view.head_m;
        let planned = self.style.planned_m_s2 * self.mood;
        let need = (view.v_m_s.powi(2) - target_m_s.powi(2)) / (2.0 * way_m.max(0.5 * view.v_m_s + 0.3));
        let slow_enough = target_m_s > 0.0 && view.v_m_s < target_m_s;
        let too_early = target_m_s == 0.0 && need < 0.3 * planned && way_m > 25.0 && view.v_m_s < 8.0;
        if slow_enough || too_early {
            self.mode = Mode::Coasting;
            self.handles.brake = 0.0;
            return;
        }
        if view.time_s - self.moved_s < self.style.patience_s {
            return;
        }
        self.moved_s = view.time_s;
        let stopping_soon = target_m_s == 0.0 && view.v_m_s < 1.2;
        if !stopping_soon {
            // A slow brake has to be waited for before its force is judged.
            let gain = 0.4 * self.style.patience_s / (self.style.lag_s + 2.0);
            let miss = (need + self.felt_m_s2) / self.style.full_m_s2;
            self.trim = (self.trim + gain * miss).clamp(-0.3, 0.4);
        }
        let share = (need - 0.03) / self.style.full_m_s2 + self.trim;
        let share = if full { 1.0 } else { share };
        self.handles.brake = self.notched(if stopping_soon { share.min(self.style.hold) } else { share });
    }

    fn retain(&mut self, view: &View, line: &Line) {
        let limit = line.limit_m_s(view.head_m);
        let (need, target_m, target_m_s) = self.needed(view, line);
        if need > self.style.planned_m_s2 * self.mood {
            self.mode = Mode::Braking { target_m, target_m_s, full: false };
        } else if view.v_m_s < limit - 0.8 {
            self.mode = Mode::Coasting;
            self.handles.brake = 0.0;
        } else if view.time_s - self.moved_s > self.style.patience_s {
            self.moved_s = view.time_s;
            let wish = 0.12 + 0.06 * (view.v_m_s - limit);
            self.handles.brake = self.notched(wish.min(0.5));
        }
    }

    fn notched(&self, share: f64) -> f64 {
        let share = share.clamp(0.1, 1.0);
        if self.style.notch > 0.0 { (share / self.style.notch).round() * self.style.notch } else { share }
            .clamp(0.1, 1.0)
    }
}
