# Input: an object with the reports of the rows, `painted`, `textured`, `ground` (freelsd-eval),
# `flights` (freelsd-fields), `places` and `blind_places` (freelsd-places); each may be null.
# Output: the tables of "Right about the world", as Markdown.

def percent: if . == null then "-" else (1000 * . | round / 10 | tostring) + " %" end;
def thousandths: if . == null then "-" else (1000 * . | round / 1000 | tostring) end;
def hundredths: if . == null then "-" else (100 * . | round / 100 | tostring) end;

# Upper 95 % bound of a rate (Clopper-Pearson): the rate at which so few are seen in 1 of 20 runs.
def chance_of_at_most($seen; $tried; $rate):
  reduce range($seen) as $i (
    {term: pow(1 - $rate; $tried), sum: pow(1 - $rate; $tried)};
    .term *= ($tried - $i) / ($i + 1) * $rate / (1 - $rate) | .sum += .term) | .sum;
def upper_bound($seen; $tried):
  if $tried == 0 or $seen >= $tried then 1
  else reduce range(40) as $i ({low: 0, high: 1};
    ((.low + .high) / 2) as $rate
    | if chance_of_at_most($seen; $tried; $rate) > 0.05 then .low = $rate else .high = $rate end)
    | .high end;
def rate($seen; $tried):
  "\($seen) of \($tried)" + (if $tried == 0 then "" else " (<= \(upper_bound($seen; $tried) | percent))" end);

# The largest counts of an object {cause: count}.
def largest($counts; $num):
  [$counts | to_entries | sort_by(-.value, .key)[:$num][] | "\(.key) \(.value)"]
  | if length == 0 then "-" else join("; ") end;
def sum_of($objects): reduce ($objects[] | to_entries[]) as $entry ({}; .[$entry.key] += $entry.value);

def num_judged: .safety | .num_landable_sites + .num_unverified_sites - .num_in_doubt;
def row($name; $cells): "| \($name) | \($cells | join(" | ")) |";

def world_cells:
  [rate(.safety.num_false_safe; num_judged),
   "\(.safety.num_false_safe_thin)",
   "\(.flown.failure_ratio | percent) (\(.flown.failure_ratio_low_95 | percent) to "
     + "\(.flown.failure_ratio_high_95 | percent)), thin \(.flown.failure_ratio_thin | percent)",
   "\(.found.num_found_of_accepted) of \(.found.fields_accepted_on_truth)"
     + " (\(.found.found_of_accepted_ratio | percent))",
   (.maps.grass_calibration_error | hundredths)];
def flight_counts: [.surveys[].counts] | sum_of(.);
def flight_fields: [.surveys[].fields[] | select((.winds_that_fit | length) > 0)];
def flight_cells:
  (flight_counts) as $counts | (flight_fields) as $fields
  | ($fields | map(select((.winds_found | length) > 0)) | length) as $found
  | [rate($counts.false_safe; $counts.right + $counts.false_safe)
       + ", not judged \($counts.not_judged)",
     "\($counts.thin)", "-", "\($found) of \($fields | length)", "-"];
def place_cells:
  .pooled as $all
  | ($all.by_class | to_entries | map(select(.key != "grass").value)) as $others
  | [rate([$others[].num_called_grass] | add; [$others[].num_answered] | add),
     "-", "-",
     "\($all.by_class.grass.num_called_grass) of \($all.by_class.grass.num_answered)",
     ($all.calibration_error | hundredths)];

def main_table:
  "| row | false safe, of those judged (95 % bound) | thin | flown failures (95 %) | found | calibration error |",
  "|---|---|---|---|---|---|",
  (if .painted then row("painted worlds"; .painted | world_cells) else empty end),
  (if .textured then row("painted, with recorded texture"; .textured | world_cells) else empty end),
  (if .ground then row("real ground"; .ground | world_cells) else empty end),
  (if .flights then row("recorded flights"; .flights | flight_cells) else empty end),
  (if .places then row("new places (polygons)"; .places | place_cells) else empty end);

def cause_table:
  "| row | largest causes of loss | largest causes of danger | of failures when flown |",
  "|---|---|---|---|",
  (["painted", "textured", "ground"][] as $name | .[$name] | select(.)
   | row($name;
         [largest(.found.reasons_of_lost_fields; 3),
          largest(sum_of([.safety.false_safe_causes, .safety.thin_causes]); 3),
          largest(sum_of([.flown.causes, .flown.thin_causes]); 3)])),
  (.flights | select(.)
   | row("flights";
         [largest([flight_fields[] | select((.winds_found | length) == 0) | {(.fate): 1}] | sum_of(.); 3),
          largest([.surveys[].sites[].causes // {}] | sum_of(.); 3), "-"])),
  (.places | select(.) | .pooled.by_class
   | row("places";
         ["grass: \(.grass.num_answered - .grass.num_called_grass) not called grass, "
            + "\(.grass.num_polygons - .grass.num_answered) without an answer",
          largest([to_entries[] | select(.key != "grass" and .value.num_called_grass > 0)
                   | {(.key): .value.num_called_grass}] | sum_of(.); 3), "-"]));

def group_table($part; $title):
  "| \($title) | " + (["painted", "textured", "ground"] | join(" | ")) + " |", "|---|---|---|---|",
  (. as $all | [.painted, .textured, .ground | select(.) | .found[$part] | keys[]] | unique[] as $class
   | row($class; [["painted", "textured", "ground"][] as $name
                  | $all[$name] | if . then .found[$part][$class] else null end
                  | if . then "\(.num_found) of \(.num_fields)" else "-" end]));

def blinded_world($name; $blinding):
  .[$name].blinded[$blinding]
  | if . then "\(.num_false_safe) of \(.num_accepted); \(.failure_ratio | percent); "
              + "\(.absolute_failure_ratio | percent), \(.absolute_missed_ratio | percent)" else "-" end;
def blinding_table:
  "Per cell: false safe of accepted; flown failures; by absolute heights: failures, landings off the disc. "
    + "Flights: false safe of accepted. Places: AUC.",
  "",
  "| mutation | painted | textured | ground | flights | places |", "|---|---|---|---|---|---|",
  (. as $all | ["none", "hazards", "shift", "kinds", "heights", "flat"][] as $blinding
   | row($blinding;
         [blinded_world("painted"; $blinding), blinded_world("textured"; $blinding),
          blinded_world("ground"; $blinding),
          ($all.flights
           | if . then ([.surveys[].on_labels[$blinding].counts // {}] | sum_of(.)
                        | if . == {} then "-" else "\(.false_safe) of \(.accepted)" end) else "-" end),
          (if $blinding == "none" then $all.places.pooled.auc | hundredths
           elif $blinding == "kinds" then $all.blind_places.pooled.auc | hundredths
           else "-" end)]));

def truth_table:
  "| row | planner on maps without error: false safe | thin | fields it accepts, of all landable | its reasons for the others |",
  "|---|---|---|---|---|",
  (["painted", "textured", "ground"][] as $name | .[$name] | select(.)
   | row($name; ["\(.found.num_false_safe_on_truth)", "\(.found.num_false_safe_thin_on_truth)",
                 "\(.found.fields_accepted_on_truth) of \(.safety.num_fields_in_world)",
                 largest(.found.reasons_on_truth; 4)]));

def map_table:
  "| row | height error m, RMS | without shift | without shift and tilt | noise in 20 m, median | 90 % | processor s a world |",
  "|---|---|---|---|---|---|---|",
  (["painted", "textured", "ground"][] as $name | .[$name] | select(.)
   | row($name; [(.maps | .elevation_rmse_m, .elevation_rmse_unbiased_m, .elevation_rmse_detilted_m,
                  .local_noise_median_m, .local_noise_p90_m | hundredths), (.cpu_s_per_world.all | hundredths)]));

def height_table:
  "Open ground that three photographs see, without the plane that a world's errors have in common. "
    + "The largest of the worlds is in brackets.",
  "",
  "| row | height error m, median | 95 % | beyond 3 told deviations | RMS beyond 3 m of tall things "
    + "(with the plane) | steps between cells m, 99 % | unknown |",
  "|---|---|---|---|---|---|---|",
  (["painted", "textured", "ground"][] as $name | .[$name] | select(.) | .heights | select(.)
   | row($name;
         ["\(.median_m | thousandths) (\(.worlds_median_m.largest | thousandths))",
          "\(.p95_m | thousandths) (\(.worlds_p95_m.largest | thousandths))",
          "\(.beyond_3_sd_ratio | percent) (\(.worlds_beyond_3_sd_ratio.largest | percent))",
          "\(.by_place["far, plane off"].rms_m | thousandths) "
            + "(\(.by_place["far, shift off"].rms_m | thousandths))",
          "\(.step_p99_m | thousandths) (\(.worlds_step_p99_m.largest | thousandths))",
          "\(.unknown_ratio | percent) (\(.worlds_unknown_ratio.largest | percent))"]));

def thing_table:
  ([.painted, .textured, .ground | select(.) | .things | to_entries[]]
   | group_by(.key) | map({key: .[0].key, value: (map(.value) | sum_of(.))})) as $things
  | "Over all three rows. Kind / width in m / height in m.", "",
    "| thing | found | unknown | hazard without height | missed |", "|---|---|---|---|---|",
    ($things[] | row(.key; [.value | .num_found // .found, .num_unknown // .unknown,
                            .num_hazard // .hazard, .num_missed // .missed | tostring]));

"### The table", "", main_table, "", "### Causes", "", cause_table, "",
"### Found, by room (clear touchdowns on a lattice of 3 m)", "", group_table("by_room"; "room"), "",
"### Found, by the photographed share of disc, roll and final", "",
group_table("by_photographed_ratio"; "share"), "",
"### Mutations: engines blinded on purpose", "", blinding_table, "",
"### The planner on maps without error", "", truth_table, "",
"### Heights", "", height_table, "", map_table, "", "### Things on the ground", "", thing_table
