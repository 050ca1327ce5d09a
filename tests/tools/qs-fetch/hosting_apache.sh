# Apache as qs-hosting(7) sets it up, with the modules that Debian's loads by itself and those that the page names.
source "$QS_SOURCE/tests/tools/qs-fetch/servers.bash"
needs apache2
prepare_hosting
mkdir apache
modules=/usr/lib/apache2/modules user=
((EUID)) || user=$'User www-data\nGroup www-data'
named=$(sed -n 's/^\.BR "a2enmod \(.*\)" .*/\1/p' "$QS_SOURCE/man/qs-hosting.7")
for module in mpm_event authn_core authz_core authz_user socache_shmcb $named; do
    echo "LoadModule ${module}_module $modules/mod_$module.so"
done > apache/modules
hosting_config "# /etc/apache2/sites-available/models.conf" > apache/site
cat > apache/conf << CONF
ServerRoot $PWD/apache
ServerName localhost
Listen 127.0.0.1:$port
Listen 127.0.0.1:$tls_port
PidFile $PWD/apache/pid
ErrorLog $PWD/apache/error.log
$user
Include $PWD/apache/modules
Include $PWD/apache/site
CONF
start apache2 -f "$PWD/apache/conf" -D FOREGROUND
wait_for answers "$tls_port"
check_hosting
