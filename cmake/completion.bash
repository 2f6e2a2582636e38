# bash completion for ferrule: verbs, options and their choices as --help states them, and the names
# of the installed scenes and devices. Anything else: files.
_ferrule() {
  local program=${COMP_WORDS[0]} verb=${COMP_WORDS[1]}
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} choices='' help shared
  if [[ $COMP_CWORD -eq 1 ]]; then
    choices="--help --version $("$program" --help 2>/dev/null |
      sed -n 's/^  \([a-z][a-z-]*\) .*/\1/p')"
  else
    help=$("$program" "$verb" --help 2>/dev/null)
    shared=$(dirname "$(dirname "$(readlink -f "$(type -P "$program")")")")/share/ferrule
    case $before,$word in
      *,-*) choices=$(grep -oE '^ +(-h,)?--[a-z-]+' <<<"$help" | grep -oE -- '--[a-z-]+') ;;
      --scene,* | --transfer,*) choices=$(basename -s .json "$shared"/scenes/*.json | grep -v schema) ;;
      --set,*) choices=$("$program" scene 2>/dev/null | sed -nE 's/^([a-z_]+(\.[A-Za-z0-9_]+)*) .*/\1=/p') ;;
      --profile,*) choices=$(basename -s .json "$shared"/devices/*.json | grep -v schema) ;;
      --*) choices=$(sed -nE "s/^ +$before .*\{([a-z0-9,._-]+)\}.*/\1/p" <<<"$help" | tr , ' ') ;;
    esac
  fi
  mapfile -t COMPREPLY < <(compgen -W "$choices" -- "$word")
}
complete -o default -F _ferrule ferrule
