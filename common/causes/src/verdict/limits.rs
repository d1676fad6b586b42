//! Every threshold of the verdict, with where it comes from.

use crate::grip::Usual;

/// Share of values missing; a loose contact loses more, a healthy line a thousandth.
pub(super) const MISSING: f64 = 0.012;
/// Nothing from a wheelset for so long is more than a gap, s.
pub(super) const SILENT_WHEEL_S: f64 = 20.0;
/// Nothing from a wagon for so long, s.
pub(super) const SILENT_WAGON_S: f64 = 8.0;
/// Once a turn, relative, beyond the train's middle: mounting tolerances are below a thousandth.
pub(super) const ONCE_A_TURN: f64 = 0.0018;
/// Largest deviation of a second beyond the train's middle, in declared sigmas, that no noise reaches on average.
pub(super) const RINGS: f64 = 2.0;
/// From here on creepage is not asked.
pub(super) const RINGS_DOUBTFUL: f64 = 12.0;
/// A wheel later than the others, s: filters of speed encoders differ by hundredths.
pub(super) const LATE_WHEEL_S: f64 = 0.06;
/// From here on a late wheel is not asked what holds it back, s.
pub(super) const LATE_DOUBTFUL_S: f64 = 0.03;
/// A wrong scale is known when the latest roll shows the same creepage at rest as all that was learnt, within this; hand-set, an eighth of
/// [`RADIUS`].
pub(super) const KNOWN: f64 = 6e-4;
/// A speed later than the train's, s.
pub(super) const LATE_SPEED_S: f64 = 0.075;
/// The same where the wagon runs alone, so that its wheels are all there is beside it: they slip.
pub(super) const LATE_SPEED_ALONE_S: f64 = 0.25;
/// And a lag explains at least this share of the variance of what the wheels are behind by. Hand-set: of two railcars on wet rails (seed
/// 291128) it explained 0.56 and 0.69, of four whose speeds were late 0.90 and more once the past before had faded.
pub(super) const A_LAG_EXPLAINS: f64 = 0.8;
/// Everything of a wagon later than the train's, s, where the wagons of the train hardly differ, s.
pub(super) const LATE_CLOCK_S: (f64, f64) = (0.12, 0.03);
/// Radius error beyond the train's middle: files are good to a few thousandths between two measurements of wear.
pub(super) const RADIUS: f64 = 0.0046;
/// And so many spreads of all wheelsets of the train, where as many differ from their files: that is wear, and no entry that is wrong.
pub(super) const RADII_BEYOND: f64 = 3.5;
/// More than [`RADIUS`], of a wheel that has only been seen at work, up to a creepage of 1.2e-3: a wet rail, on which the first wheel
/// that drives or brakes gives way by three times what it should, adds so much. Hand-set.
pub(super) const NEVER_COASTED: f64 = 0.0024;
/// Scale error of a speed.
pub(super) const SPEED_SCALE: f64 = 0.0042;
/// Of two speeds one is wrong when the wheels disagree with it by so many times what is usual, and what they do with the other. Hand-set.
pub(super) const TWO_SPEEDS: f64 = 2.0;
/// Load over what was entered, less one, beyond what both are worth.
pub(super) const LOAD: f64 = 0.085;

/// The same by how a wagon that runs alone accelerates. Of 23 healthy ones with a declared load (development seeds 7101, 7102)
/// the largest was 0.025 off.
pub(super) const LOAD_ALONE: f64 = 0.075;

/// Force at a full order over the mass in the file differs between wagons of known load by so much, one sigma, and an entry is
/// wrong beyond this and so many sigmas: in 61 coupled trains with declared loads (development seeds 7101, 7102) the wagon
/// farthest from the middle of its train was 0.077 off, the usual distance 0.02.
pub(super) const PRESSED_APART: f64 = 0.03;
pub(super) const LOAD_PRESSED: (f64, f64) = (0.105, 3.5);

/// An entry that is worth no more than this is no claim: a load that nobody declared.
pub(super) const LOAD_UNKNOWN: f64 = 0.1;
/// For so long, s, pads must have stayed off while an electric brake elsewhere did what was ordered, until a train counts as blended
/// train-wide: how hard its driven wagons press for their mass then says nothing of it. Hand-set.
pub(super) const BLENDED_S: f64 = 20.0;
/// Wagons that drive are locomotives where they are fewer than this share of the train; hand-set.
pub(super) const LOCOMOTIVES: f64 = 0.3;

/// Pressing force left while released, over the largest: a transducer's offset, or a wagon that does not release.
pub(super) const LEFT: f64 = 0.03;
/// Pressing force over that of the others of its wagon: cylinders of one distributor agree within some percent.
pub(super) const BESIDE: (f64, f64) = (0.90, 1.10);
/// And within this, N: of healthy wheelsets (development seed 7104) two read 250 N too low.
pub(super) const OFFSET_N: f64 = 450.0;
/// Probabilities of two causes that what was seen does not tell apart: of what makes a force too small throughout, vents and
/// transducers; hand-set.
pub(super) const EITHER: (f64, f64) = (0.55, 0.4);
/// Below this it is without a brake.
pub(super) const NO_FORCE: f64 = 0.22;
/// The share sinks by at least this from the first seconds under pressure to later ones, and by so much of what is missing
/// then: a leak. What a vent or a cock takes is missing from the beginning.
pub(super) const LEAKS: (f64, f64) = (0.05, 0.4);
/// An application tells who is without a brake after so long, s, if at least this much was ordered.
pub(super) const TELLING: (f64, f64) = (10.0, 0.15);
/// A wagon whose largest force stays below this share of what it once had does not brake.
pub(super) const NOT_PRESSED: f64 = 0.05;
/// The pads must have owed force for so long, s, before a wagon counts as without a brake.
pub(super) const OWED_S: f64 = 8.0;
/// The same while the application runs, so that pads may still come, s; hand-set, twice as long.
pub(super) const OWED_RUNNING_S: f64 = 16.0;
/// A rise or a fall that begins later than usual by this, s, is late; scatter at least this, s. Of 4,000 rises and 4,300 falls
/// of healthy wagons (development seeds 7101, 7102) one in a hundred began 0.3 s and 0.7 s later than its own past.
pub(super) const LATE: (f64, f64) = (0.8, 0.25);
/// A fall is slow when it takes longer by this (natural logarithm), with at least this scatter: of the same falls, one in a
/// thousand took 0.10 longer, the longest 0.21.
pub(super) const SLOW_FALL: (f64, f64) = (0.35, 0.1);
/// A rise is slow when the area between order and force is larger by this, s, and this share of the usual, with at least such a
/// share of scatter: of the same rises one in a hundred had 0.6 more.
pub(super) const SLOW_RISE: (f64, f64, f64) = (0.3, 0.5, 0.15);
/// More than one wagon, and more than this share of those that tell: it is the order that came otherwise.
pub(super) const SEVERAL: f64 = 0.08;
/// No single look counts for more than this, natural logarithm of odds.
pub(super) const MOST_ODDS: f64 = 4.0;
/// And so much makes an alert: two clear looks, of which a rise and the fall after it are one each.
pub(super) const TOLD_LATER: f64 = 7.0;

/// Pads have lost at least this, relative, and so many sigmas; without the application that says most, half as many. Of 67
/// healthy trains (development seeds 7101 to 7103) the largest such loss was three sigmas.
pub(super) const PADS: (f64, f64) = (-0.13, -3.7);
/// No pads of a wagon lose more than this of nominal while they press: what seems so is couplers. Of one wheelset beside its wagon,
/// where couplers have no part, nobody says by how much it exceeds this.
pub(super) const PADS_GONE: f64 = -0.55;
/// The pads of a wagon have lost: by how much likelier (natural logarithm) the differences within it are if one wheelset did it until that
/// one is named. Hand-set, one in twenty.
pub(super) const ONE_DID: f64 = 3.0;
/// Where there is no past, radii are learnt from the same applications: so many must agree. Hand-set.
pub(super) const WITHOUT_PAST: usize = 3;
/// Of a wagon that runs alone: at least this must be missing in its balance of forces, relative, over its wheelsets. What creepage says
/// of the size counts for nothing on a steep curve; hand-set, somewhat less than [`PADS`] of what can be told at all.
/// And so many sigmas: without a past nobody knows how well its pads grip.
pub(super) const SHOWS: (f64, f64) = (-0.2, -2.5);
/// Wagons so near on either side have come to grip less as well, by this share, and so many sigmas: couplers hold that part of the train
/// back. Hand-set.
pub(super) const NEIGHBOURS: (usize, f64, f64) = (2, 0.4, -1.5);
/// The same wheelset of wagons of its kind has come to creep less as well, by this share, and so many sigmas. Hand-set.
pub(super) const PEERS: (f64, f64) = (0.4, -1.5);
/// Of three wheelsets or more, one that has come to creep more by this share of what another has come to creep less: one of four that
/// slips makes a third as much of each of the others, one whose pads are glazed makes the others creep more by a third.
pub(super) const SLIPS: f64 = 0.8;
/// Where several wagons are accused, the one that stands out most is told if no other has this share of its sigmas.
pub(super) const ALONE: f64 = 0.6;
/// Creepage at rest changed by at least this, and so many sigmas.
pub(super) const DRAGS: (f64, f64) = (-6e-5, -6.0);
/// And by so many spreads of all wheelsets of the train.
pub(super) const DRAGS_BEYOND: f64 = -4.0;
/// Of three wheelsets or more, one that runs ahead of the mean of the others by this times what any of them stays behind: one of
/// four that is fast makes 3, two that drag make 1, one that drags makes a third.
pub(super) const AHEAD: f64 = 2.0;
/// Where each roll says too little: so many must say it together.
pub(super) const HELD_ROLLS: usize = 3;
/// Creepage at rest beside the others before the first roll, one sigma: radii differ by percents.
pub(super) const REST_UNKNOWN: Usual = Usual::radii(0.02);
/// Resistance of a wagon that runs alone, over its weight, and so many sigmas.
pub(super) const DRAGS_ALONE: (f64, f64) = (-1.5e-3, -5.0);

/// By so many sigmas one wheelset must be held back more than the next until it alone is named; hand-set.
pub(super) const CLEARER: f64 = 3.0;

/// Wheelsets that must slide within some seconds until it is the rail and not a wheelset.
pub(super) const SLIDING_WHEELSETS: usize = 2;
/// Slid with full pressure for so long, s: slide protection did nothing.
pub(super) const STUCK_S: f64 = 3.0;
