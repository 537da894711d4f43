# A folder as a camera leaves it on a card. Part of freelsdctl.sh.
# shellcheck shell=bash disable=SC2154 # set there

# As a card leaves a camera: two folders with equal names, thumbnails, videos, and a geo.txt beside them.
test_card() {
  local card="$work/card" other number
  mkdir -p "$card/DCIM/"{100,101}MEDIA "$card/MISC/THM/100"
  cp "$rendered/frame_0001.jpg" "$rendered/frame_0002.jpg" "$card/DCIM/100MEDIA"
  cp "$rendered/frame_0003.jpg" "$card/DCIM/101MEDIA/frame_0001.jpg"
  cp "$rendered/frame_0001.jpg" "$card/DCIM/100MEDIA/._frame_0001.jpg"
  touch "$card/MISC/THM/100/frame_0001.THM" "$card/DCIM/100MEDIA/film.MP4" "$card/DCIM/100MEDIA/film.SRT"
  { echo EPSG:4326; for number in 2 3; do echo "FRAME_000$number 8.45 47.35 550"; done; } >"$card/geo.txt"
  cp "$rendered/flight.json" "$card"
  run 1 submit "$card" --dry-run
  said err "photographs from $card/DCIM/100MEDIA $card/DCIM/101MEDIA: 3"
  said err "poses from $card/geo.txt"
  said err 'left: videos and their files \(2\), thumbnails and files of file managers \(2\)'
  said err 'DCIM_100MEDIA_frame_0001.jpg: .*give a position'
  equal "$(grep -c '^freelsdctl: \(photographs\|poses\|left\)' "$work/err")" 3 "lines"
  run 2 submit "$card" --angles sideways
  said err '--angles must be checked, given or none'
  echo "a card: its photographs are sent, and the rest is told"
}
