MODULE WbPick
    ! Asks the pick server of the workbench, and moves along what it answers.
    ! docs/pick_server.md has every line. Lines of 80 bytes, degrees, checks, a robot of six axes.
    ! The hand is in pick_open and pick_grip: write there what your tool does.

    CONST string PICK_ADDRESS:="192.168.0.20";
    CONST num PICK_PORT:=1025;
    CONST string PICK_VERSION:="pick-server/1";
    CONST num PICK_AXES:=6;
    CONST num PICK_MOST:=64;
    CONST num PICK_LINE:=80;

    ! [s] without an answer, after which a line is sent again; and between two questions.
    CONST num PICK_AGAIN:=1;
    CONST num PICK_PAUSE:=0.1;

    PERS num pick_run:=0;
    PERS loaddata pick_load:=[0.001,[0,0,0.001],[1,0,0,0],0,0,0];
    PERS tooldata pick_tool:=[TRUE,[[0,0,0],[1,0,0,0]],[0.001,[0,0,0.001],[1,0,0,0],0,0,0]];

    VAR socketdev pick_socket;
    VAR bool is_connected:=FALSE;
    VAR string session;
    VAR num request:=0;
    VAR string word{12};
    VAR num words:=0;
    VAR jointtarget waypoint{64};
    VAR num duration{64};
    VAR bool has_part:=FALSE;
    VAR bool is_released:=FALSE;

    PROC main()
        VAR num legs;

        pick_run:=pick_run MOD 9999+1;
        request:=0;
        session:="";
        SocketClose pick_socket;
        is_connected:=FALSE;
        WHILE TRUE DO
            ask_until_done "next"+axes_now();
            IF word{2}="PLAN" THEN
                legs:=number_of(word{4});
                run_plan legs;
            ELSE
                ask_until_done "scan";
                IF word{2}="OK" ask_until_done "find";
                WaitTime PICK_PAUSE;
            ENDIF
        ENDWHILE
    ENDPROC

    ! One plan: a leg that was answered may be run once.
    PROC run_plan(num legs)
        VAR num points;
        VAR string hand;
        VAR num opening;

        has_part:=FALSE;
        is_released:=FALSE;
        FOR leg FROM 1 TO legs DO
            ask "leg "+NumToStr(leg,0);
            hand:=word{4};
            opening:=number_of(word{5});
            points:=number_of(word{6});
            take_load;
            IF points>PICK_MOST give_up "too many waypoints";
            FOR k FROM 1 TO points DO
                ask "point "+NumToStr(leg,0)+" "+NumToStr(k,0);
                take_point k;
            ENDFOR
            move_hand hand,opening;
            FOR k FROM 1 TO points DO
                MoveAbsJ waypoint{k},v1000\T:=duration{k},fine,pick_tool;
            ENDFOR
            ask "done "+NumToStr(leg,0)+axes_now();
            IF hand="grip" THEN
                IF has_part THEN
                    ask "picked";
                ELSE
                    ask "failed missed";
                ENDIF
            ENDIF
        ENDFOR
    ENDPROC

    PROC move_hand(string hand,num opening)
        IF hand="open" THEN
            pick_open opening;
            IF has_part AND NOT is_released THEN
                ask "placed";
                is_released:=TRUE;
            ENDIF
        ELSEIF hand="grip" THEN
            has_part:=pick_grip(opening);
        ENDIF
        GripLoad pick_load;
    ENDPROC

    ! Opens the hand to this many mm.
    PROC pick_open(num opening)
    ENDPROC

    ! Grips what is this many mm wide; whether the hand holds it.
    FUNC bool pick_grip(num opening)
        RETURN TRUE;
    ENDFUNC

    ! Tool and part together; 0 kg where the cell does not state it.
    PROC take_load()
        IF number_of(word{8})>0 THEN
            pick_load.mass:=number_of(word{8});
            pick_load.cog.x:=number_of(word{9});
            pick_load.cog.y:=number_of(word{10});
            pick_load.cog.z:=number_of(word{11});
        ELSE
            pick_load:=load0;
        ENDIF
    ENDPROC

    PROC take_point(num k)
        waypoint{k}:=CJointT();
        waypoint{k}.robax.rax_1:=number_of(word{3});
        waypoint{k}.robax.rax_2:=number_of(word{4});
        waypoint{k}.robax.rax_3:=number_of(word{5});
        waypoint{k}.robax.rax_4:=number_of(word{6});
        waypoint{k}.robax.rax_5:=number_of(word{7});
        waypoint{k}.robax.rax_6:=number_of(word{8});
        duration{k}:=number_of(word{10});
    ENDPROC

    FUNC string axes_now()
        VAR jointtarget here;

        here:=CJointT();
        RETURN " "+NumToStr(here.robax.rax_1,2)+" "+NumToStr(here.robax.rax_2,2)+
            " "+NumToStr(here.robax.rax_3,2)+" "+NumToStr(here.robax.rax_4,2)+
            " "+NumToStr(here.robax.rax_5,2)+" "+NumToStr(here.robax.rax_6,2);
    ENDFUNC

    ! Asks for a job until its answer is not WAIT.
    PROC ask_until_done(string job)
        ask job;
        WHILE word{2}="WAIT" DO
            WaitTime PICK_PAUSE;
            ask "state"+axes_now();
            ask job;
        ENDWHILE
    ENDPROC

    ! The words of the answer to one job; the same line is sent until it comes.
    PROC ask(string job)
        VAR string line;

        request:=request MOD 9999+1;
        line:=NumToStr(request,0)+" "+job;
        WHILE NOT answered(line,request) DO
            IF NOT is_connected greet;
        ENDWHILE
        IF word{2}="STOP" give_up word{3};
        IF word{2}="ERR" give_up word{3};
    ENDPROC

    ! Nothing more of the plan is moved; the program begins again at main.
    PROC give_up(string why)
        TPWrite "pick server: "+why;
        request:=request MOD 9999+1;
        IF answered(NumToStr(request,0)+" stop",request) TPWrite "stop is reported";
        SocketClose pick_socket;
        EXIT;
    ENDPROC

    PROC greet()
        SocketClose pick_socket;
        SocketCreate pick_socket;
        SocketConnect pick_socket,PICK_ADDRESS,PICK_PORT\Time:=PICK_AGAIN;
        is_connected:=TRUE;
        IF NOT answered("0 hello "+PICK_VERSION+" "+NumToStr(pick_run,0),0) THEN
            is_connected:=FALSE;
            RETURN;
        ENDIF
        IF word{2}<>"OK" THEN
            is_connected:=FALSE;
            RETURN;
        ENDIF
        IF session<>"" AND session<>word{4} THEN
            TPWrite "another server answers";
            EXIT;
        ENDIF
        session:=word{4};
    ERROR
        WaitTime PICK_PAUSE;
        RETURN;
    ENDPROC

    ! Sends one line, and reads until its answer has come, or none in time.
    FUNC bool answered(string line,num number)
        VAR string heard;

        IF NOT is_connected RETURN FALSE;
        SocketSend pick_socket\Str:=line+" "+check_of(line)+"\0A";
        WHILE read_line(heard) DO
            IF split(heard) THEN
                IF word{1}=NumToStr(number,0) RETURN TRUE;
                IF word{1}="0" AND word{2}="ERR" RETURN FALSE;
            ENDIF
        ENDWHILE
        RETURN FALSE;
    ERROR
        is_connected:=FALSE;
        RETURN FALSE;
    ENDFUNC

    ! The next line without its end; FALSE when none came in time, or the link is gone.
    FUNC bool read_line(INOUT string line)
        VAR string letter;

        line:="";
        WHILE TRUE DO
            SocketReceive pick_socket\Str:=letter\ReadNoOfBytes:=1\Time:=PICK_AGAIN;
            IF letter="\0A" RETURN TRUE;
            IF StrLen(line)<PICK_LINE line:=line+letter;
        ENDWHILE
        RETURN FALSE;
    ERROR
        IF ERRNO<>ERR_SOCK_TIMEOUT is_connected:=FALSE;
        RETURN FALSE;
    ENDFUNC

    ! Takes a line apart into words, without its check; FALSE when the check is wrong.
    FUNC bool split(string line)
        VAR num first:=1;
        VAR num past;

        words:=0;
        WHILE first<=StrLen(line) AND words<Dim(word,1) DO
            past:=StrFind(line,first," ");
            Incr words;
            word{words}:=StrPart(line,first,past-first);
            first:=past+1;
        ENDWHILE
        IF words<3 RETURN FALSE;
        past:=StrLen(line)-StrLen(word{words});
        IF word{words}<>check_of(StrPart(line,1,past-1)) RETURN FALSE;
        Decr words;
        RETURN TRUE;
    ENDFUNC

    FUNC string check_of(string line)
        VAR num value:=0;
        VAR string text;

        FOR k FROM 1 TO StrLen(line) DO
            value:=(value*31+StrToByte(StrPart(line,k,1)\Char)) MOD 65521;
        ENDFOR
        text:=NumToStr(value,0);
        WHILE StrLen(text)<5 DO
            text:="0"+text;
        ENDWHILE
        RETURN text;
    ENDFUNC

    FUNC num number_of(string text)
        VAR num value:=0;

        IF NOT StrToVal(text,value) give_up "no number: "+text;
        RETURN value;
    ENDFUNC
ENDMODULE
