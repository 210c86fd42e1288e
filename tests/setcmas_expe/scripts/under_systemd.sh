# Starts a service under a systemd of its own, lets it run, hangs it; prints what systemd says.
#
#     unshare --mount --pid --fork --mount-proc --cgroup --propagation private \
#         bash under_systemd.sh UNIT_FILE INSTANCE SECONDS COMMAND...
#
# COMMAND replaces the unit's. systemd finds these units and no others, so nothing cleans or mounts
# anything; what it writes to /tmp, /run and /var goes to memory.
set -e
unit_file=$1 instance=$2 seconds=$3
shift 3
mount -t tmpfs none /run
for folder in tmp var; do
    mkdir "/run/$folder" "/run/$folder.work"
    mount -t overlay -o "lowerdir=/$folder,upperdir=/run/$folder,workdir=/run/$folder.work" none "/$folder"
done
touch /run/log
mount --bind /run/log /dev/console
export XDG_RUNTIME_DIR=/run/user SYSTEMD_UNIT_PATH=/run/units
export SYSTEMD_GENERATOR_PATH=/run/none SYSTEMD_ENVIRONMENT_GENERATOR_PATH=/run/none
name=$(basename "$unit_file" @.service)@
mkdir -p /run/systemd/system /run/user "/run/units/$name.service.d"
for target in basic default shutdown; do
    printf '[Unit]\nDefaultDependencies=no\n' > "/run/units/$target.target"
done
cp "$unit_file" /run/units
printf '[Service]\nSlice=-.slice\nUser=\nEnvironmentFile=\nPassEnvironment=%s\nExecStart=\nExecStart=%s\n' \
    "$(compgen -e | tr '\n' ' ')" "$*" > "/run/units/$name.service.d/test.conf"
/lib/systemd/systemd --user --unit=default.target --log-target=console </dev/null >/run/out 2>&1 &
control() { systemctl --user "$@" "$name$instance"; }
state() { control show -p ActiveState,NRestarts | tr '\n' ' '; }
until systemctl --user is-system-running >/dev/null 2>&1; do
    kill -0 $! || { cat /run/log /run/out; exit 3; }
    sleep 0.1
done
control start || true
echo "started: $(state)"
sleep "$seconds"
echo "later: $(state)"
kill -STOP "$(control show -p MainPID --value)"
for _ in $(seq 200); do
    [[ $(state) == *'NRestarts=0'* || $(state) != *'ActiveState=active'* ]] || break
    sleep 0.1
done
echo "hung: $(state)"
control stop
