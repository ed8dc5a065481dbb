// SPDX-License-Identifier: GPL-3.0-or-later
// What of each result is kept. The order of the members is that of the record.
#include "bouncelab/core/impacts.hpp"
#include "bouncelab/core/onsets.hpp"
#include "bouncelab/loop/records.hpp"
#include "journal/packed.hpp"

namespace bouncelab {

template <class T, class Use>
requires std::is_same_v<std::remove_const_t<T>, Onset>
void members(T& o, const Use& use) {
  use(o.drop, o.impact, o.t_s, o.sigma_t_s, o.amplitude, o.snr_db, o.flags, o.probability);
}

template <class T, class Use>
requires std::is_same_v<std::remove_const_t<T>, Impact>
void members(T& i, const Use& use) {
  use(i.drop, i.impact, i.t_s, i.v_mps, i.v_after_mps, i.eps_macro, i.v_contact_mps, i.eps_contact, i.asperity);
}

template <class T, class Use>
requires std::is_same_v<std::remove_const_t<T>, ImpactState>
void members(T& s, const Use& use) {
  use(s.position_m, s.orientation, s.velocity_mps, s.spin_radps, s.velocity_after_mps, s.spin_after_radps, s.energy_j,
      s.energy_after_j, s.dissipated_j, s.created_j);
}

template <class T, class Use>
requires std::is_same_v<std::remove_const_t<T>, Impacts>
void members(T& i, const Use& use) { use(i.rows, i.states); }

}  // namespace bouncelab

namespace bouncelab::detection {

template <class T, class Use>
requires std::is_same_v<std::remove_const_t<T>, DropSummary>
void members(T& d, const Use& use) { use(d.begin_s, d.n_impacts, d.odds); }

template <class T, class Use>
requires std::is_same_v<std::remove_const_t<T>, RecordingSummary>
void members(T& s, const Use& use) {
  use(s.format, s.lossy_coding, s.ffmpeg, s.rate_hz, s.n_channels, s.channel, s.channel_reason, s.duration_s,
      s.noise_rms, s.contact_time_at_1_mps_s, s.contact_time_sigma_s, s.n_candidates, s.n_drops, s.restitution_median);
}

template <class T, class Use>
requires std::is_same_v<std::remove_const_t<T>, LearnedWave>
void members(T& w, const Use& use) { use(w.t0_s, w.dt_s, w.mean, w.spread, w.n_impacts); }

template <class T, class Use>
requires std::is_same_v<std::remove_const_t<T>, NoiseSpectrum>
void members(T& n, const Use& use) { use(n.frequency_hz, n.psd); }

template <class T, class Use>
requires std::is_same_v<std::remove_const_t<T>, Detection>
void members(T& d, const Use& use) {
  use(d.status, d.message, d.warnings, d.summary, d.drops, d.onsets, d.wave, d.noise);
}

}  // namespace bouncelab::detection

namespace bouncelab::sim {

template <class T, class Use>
requires std::is_same_v<std::remove_const_t<T>, KineticEnergy>
void members(T& e, const Use& use) { use(e.vertical_j, e.horizontal_j, e.rotational_j); }

template <class T, class Use>
requires std::is_same_v<std::remove_const_t<T>, EnergyLedger>
void members(T& e, const Use& use) {
  use(e.released_j, e.remaining_j, e.dissipated_j, e.created_j, e.drag_j, e.n_creating, e.gained_impact_j);
}

template <class T, class Use>
requires std::is_same_v<std::remove_const_t<T>, DropResult>
void members(T& d, const Use& use) { use(d.end, d.energy, d.impacts); }

}  // namespace bouncelab::sim

namespace bouncelab::synthesis {

template <class T, class Use>
requires std::is_same_v<std::remove_const_t<T>, TrueImpact>
void members(T& i, const Use& use) {
  use(i.drop, i.impact, i.t_s, i.sigma_t_s, i.amplitude, i.snr_db, i.contact_time_s, i.travel_time_s, i.x_m, i.y_m,
      i.v_mps, i.flags);
}

template <class T, class Use>
requires std::is_same_v<std::remove_const_t<T>, OtherSound>
void members(T& s, const Use& use) { use(s.kind, s.t_s); }

template <class T, class Use>
requires std::is_same_v<std::remove_const_t<T>, DropTruth>
void members(T& d, const Use& use) { use(d.impacts, d.others); }

template <class T, class Use>
requires std::is_same_v<std::remove_const_t<T>, Levels>
void members(T& l, const Use& use) { use(l.noise_rms, l.weakest_peak, l.gain); }

template <class T, class Use>
requires std::is_same_v<std::remove_const_t<T>, SynthesisResult>
void members(T& r, const Use& use) { use(r.n_impacts, r.n_clipped, r.n_other_sounds, r.levels, r.duration_s); }

}  // namespace bouncelab::synthesis

namespace bouncelab::fit {

template <class T, class Use>
requires std::is_same_v<std::remove_const_t<T>, Interval>
void members(T& i, const Use& use) { use(i.lo, i.hi); }

template <class T, class Use>
requires std::is_same_v<std::remove_const_t<T>, BootstrapErrors>
void members(T& b, const Use& use) { use(b.se, b.ci68, b.ci95, b.n_replicates); }

template <class T, class Use>
requires std::is_same_v<std::remove_const_t<T>, Estimate>
void members(T& e, const Use& use) {
  use(e.value, e.se, e.se_independent, e.ci68, e.ci95, e.interval_method, e.bootstrap, e.identified);
}

template <class T, class Use>
requires std::is_same_v<std::remove_const_t<T>, MemoryTest>
void members(T& t, const Use& use) { use(t.z, t.p_value); }

template <class T, class Use>
requires std::is_same_v<std::remove_const_t<T>, DropsTest>
void members(T& t, const Use& use) { use(t.ratio, t.p_value); }

}  // namespace bouncelab::fit

namespace bouncelab::loop {

template <class T, class Use>
requires std::is_same_v<std::remove_const_t<T>, SynthesizedFile>
void members(T& f, const Use& use) { use(f.truth, f.of_file); }

template <class T, class Use>
requires std::is_same_v<std::remove_const_t<T>, CalibratedQuantity>
void members(T& q, const Use& use) { use(q.name, q.truth, q.with_memory, q.independent); }

template <class T, class Use>
requires std::is_same_v<std::remove_const_t<T>, MemoryExperiment>
void members(T& e, const Use& use) {
  use(e.n_used, e.status, e.message, e.holds, e.anderson_darling_p, e.mechanism, e.by_speed, e.release, e.leak,
      e.between_drops, e.keep, e.quantities);
}

std::string to_record(const detection::Detection& found, bool with_details) {
  if (with_details || (!found.wave && !found.noise)) return to_packed_record(found);
  detection::Detection without = found;
  without.wave.reset();
  without.noise.reset();
  return to_packed_record(without);
}

detection::Detection detection_from_record(std::string_view record, const std::string& recording) {
  auto found = from_packed_record<detection::Detection>(record);
  for (Onset& onset : found.onsets) onset.recording = recording;
  return found;
}

std::string to_record(const sim::DropResult& drop) { return to_packed_record(drop); }

sim::DropResult simulated_drop_from_record(std::string_view record) {
  return from_packed_record<sim::DropResult>(record);
}

std::string to_record(const synthesis::DropTruth& truth, const synthesis::SynthesisResult& of_file) {
  return to_packed_record(SynthesizedFile{truth, of_file});
}

SynthesizedFile synthesized_file_from_record(std::string_view record, const std::filesystem::path& recording) {
  auto file = from_packed_record<SynthesizedFile>(record);
  file.truth.recording = recording;
  return file;
}

std::string to_record(const std::vector<fit::Estimate>& estimates) { return to_packed_record(estimates); }

std::vector<fit::Estimate> estimates_from_record(std::string_view record) {
  return from_packed_record<std::vector<fit::Estimate>>(record);
}

std::string to_record(const fit::Replicate& replicate) { return to_packed_record(replicate); }

fit::Replicate replicate_from_record(std::string_view record) { return from_packed_record<fit::Replicate>(record); }

std::string to_record(const MemoryExperiment& experiment) { return to_packed_record(experiment); }

MemoryExperiment memory_experiment_from_record(std::string_view record, const MemoryConditions& conditions) {
  auto experiment = from_packed_record<MemoryExperiment>(record);
  experiment.conditions = conditions;
  return experiment;
}

}  // namespace bouncelab::loop
